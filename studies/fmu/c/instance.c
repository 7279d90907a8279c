/* An instance of the model: its values, its steps, and what is wrong with a call. */

#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The step, compiled by LLVM: numbers of the machine, inputs, state, whether it begins, duration [s], outputs. */
int apesim_step(int64_t *status, void **exception, double *numbers, double *inputs, double *state, int64_t begin,
                double duration, double *outputs);

#define LONGEST_TEXT 400
/* Largest distance of two times that are the same, over the length of a step: rounding in the importer's sums. */
#define SAME_TIME 1e-6

void fail(Instance *instance, const char *format, ...)
{
    char text[LONGEST_TEXT];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    instance->report(instance, text);
}

void reset_instance(Instance *instance)
{
    Content *content = &instance->content;
    memset(content, 0, sizeof *content);
    memcpy(content->parameters, parameter_starts, sizeof(double) * PARAMETER_COUNT);
    memcpy(content->inputs, input_starts, sizeof content->inputs);
    content->mode = INSTANTIATED;
    content->is_new = 1;
}

Instance *new_instance(const char *name, const char *token, Report report, void *environment, void (*logger)(void))
{
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance)
        return NULL;
    size_t length = strlen(name ? name : "") + 1;
    instance->report = report;
    instance->environment = environment;
    instance->logger = logger;
    instance->name = calloc(length, 1);
    if (instance->name)
        memcpy(instance->name, name ? name : "", length - 1);
    if (!instance->name || !token || strcmp(token, TOKEN)) {
        if (instance->name)
            fail(instance, "the token of the model description is not that of this library: the FMU is mixed up");
        free_instance(instance);
        return NULL;
    }
    reset_instance(instance);
    return instance;
}

void free_instance(Instance *instance)
{
    if (!instance)
        return;
    free(instance->name);
    free(instance);
}

int may(Instance *instance, const char *function, unsigned modes)
{
    if (!instance)
        return 0;
    if (modes & IN(instance->content.mode))
        return 1;
    const char *when = instance->content.mode == INSTANTIATED   ? "before initialization"
                       : instance->content.mode == INITIALIZING ? "during initialization"
                       : instance->content.mode == FAILED       ? "after an error: reset the FMU, or restore a state"
                       : instance->content.mode == TERMINATED   ? "after its end"
                                                                : "between steps";
    fail(instance, "%s may not be called %s", function, when);
    return 0;
}

/* The machine's numbers, as the parameters change those at export. */
static int apply_parameters(Instance *instance)
{
    Content *content = &instance->content;
    memcpy(content->numbers, machine_numbers, sizeof content->numbers);
    for (int i = 0; i < EFFECT_COUNT; i++) {
        const Effect *effect = &effects[i];
        double value = content->parameters[effect->parameter], start = parameter_starts[effect->parameter];
        if (value == start)
            continue;
        if (effect->is_value)
            content->numbers[effect->number] = value;
        else
            content->numbers[effect->number] += effect->factor * (value - start);
    }
    for (int i = 0; i < ORDER_COUNT; i++)
        if (!(content->numbers[orders[i].low] < content->numbers[orders[i].high])) {
            fail(instance, "parameters contradict each other: %s", orders[i].text);
            return 0;
        }
    return 1;
}

static int step(Instance *instance, int64_t is_begin, double duration)
{
    Content *content = &instance->content;
    int64_t status = 0;
    void *exception = NULL;
    int code = apesim_step(&status, &exception, content->numbers, content->inputs, content->state, is_begin, duration,
                           content->outputs);
    if (code == 0 && status == 0)
        return 1;
    content->mode = FAILED;
    if (code != 0)
        fail(instance, "there is not enough memory for a step");
    else
        fail(instance, "the step from %g s on: %s", content->time,
             status > 0 && status < REMEDY_COUNT ? remedies[status] : "it has ended early");
    return 0;
}

int begin(Instance *instance, double start)
{
    instance->content.time = start;
    instance->content.mode = INITIALIZING;
    instance->content.is_new = 1;
    return 1;
}

/* State and outputs at the start, of the parameters and inputs that are set by now. */
static int start(Instance *instance)
{
    Content *content = &instance->content;
    if (!content->is_new)
        return 1;
    if (!apply_parameters(instance)) {
        content->mode = FAILED;
        return 0;
    }
    memcpy(content->state, start_state, sizeof content->state);
    content->is_new = 0;
    return step(instance, 1, 0.0);
}

int finish_initialization(Instance *instance)
{
    if (!start(instance))
        return 0;
    instance->content.mode = STEPPING;
    return 1;
}

int advance(Instance *instance, double from, double duration)
{
    Content *content = &instance->content;
    if (!(duration >= 0.0) || isinf(duration)) {
        fail(instance, "a step of %g s: give a length of at least 0 s", duration);
        return 0;
    }
    if (!(fabs(from - content->time) <= SAME_TIME * fmax(duration, fabs(from)) + 1e-12)) {
        fail(instance, "a step from %.17g s on, but the FMU is at %.17g s", from, content->time);
        return 0;
    }
    if (!step(instance, 0, duration))
        return 0;
    content->time = from + duration;
    return 1;
}

static Kind kind_of(unsigned reference, unsigned *place)
{
    const unsigned counts[] = {1, INPUT_COUNT, OUTPUT_COUNT, PARAMETER_COUNT, CONSTANT_COUNT};
    for (int kind = TIME; kind < UNKNOWN; kind++) {
        if (reference < counts[kind]) {
            *place = reference;
            return (Kind)kind;
        }
        reference -= counts[kind];
    }
    return UNKNOWN;
}

static int has_type(Instance *instance, unsigned reference, Kind kind, unsigned place, int is_whole)
{
    if (kind != UNKNOWN && is_whole == (kind == INPUT && input_is_whole[place]))
        return 1;
    fail(instance, "there is no variable of this type with the value reference %u", reference);
    return 0;
}

int read_value(Instance *instance, unsigned reference, int is_whole, double *value)
{
    Content *content = &instance->content;
    unsigned place = 0;
    Kind kind = kind_of(reference, &place);
    if (!has_type(instance, reference, kind, place, is_whole))
        return 0;
    if (kind == OUTPUT && (content->mode == INSTANTIATED || content->mode == INITIALIZING) && !start(instance))
        return 0;
    *value = kind == TIME        ? content->time
             : kind == INPUT     ? content->inputs[place]
             : kind == OUTPUT    ? content->outputs[place]
             : kind == PARAMETER ? content->parameters[place]
                                 : constants[place];
    return 1;
}

int write_value(Instance *instance, unsigned reference, int is_whole, double value)
{
    Content *content = &instance->content;
    unsigned place = 0;
    Kind kind = kind_of(reference, &place);
    if (!has_type(instance, reference, kind, place, is_whole))
        return 0;
    if (kind != INPUT && kind != PARAMETER) {
        fail(instance, "value reference %u is %s, and cannot be set", reference,
             kind == CONSTANT ? "fixed at export" : kind == TIME ? "the time" : "an output");
        return 0;
    }
    int is_early = content->mode == INSTANTIATED || content->mode == INITIALIZING;
    if (kind == PARAMETER && !is_early) {
        fail(instance, "%s can be set before the first step only", parameter_ranges[place].name);
        return 0;
    }
    const Range *range = kind == INPUT ? &input_ranges[place] : &parameter_ranges[place];
    if (!(value >= range->low && value <= range->high)) {
        fail(instance, "%s = %g is out of its range, %g to %g (in SI units)", range->name, value, range->low, range->high);
        return 0;
    }
    if (kind == INPUT)
        content->inputs[place] = value;
    else
        content->parameters[place] = value;
    content->is_new = content->is_new || is_early;
    return 1;
}

void *copy_content(const Instance *instance)
{
    Content *copy = malloc(sizeof *copy);
    if (copy)
        memcpy(copy, &instance->content, sizeof *copy);
    return copy;
}

#define HEAD (sizeof TOKEN)

size_t serialized_size(void) { return HEAD + sizeof(Content); }

int serialize(Instance *instance, const void *content, unsigned char *bytes, size_t size)
{
    if (size < serialized_size()) {
        fail(instance, "a state needs %zu bytes, and there is room for %zu", serialized_size(), size);
        return 0;
    }
    memcpy(bytes, TOKEN, HEAD);
    memcpy(bytes + HEAD, content, sizeof(Content));
    return 1;
}

void *deserialize(Instance *instance, const unsigned char *bytes, size_t size)
{
    if (size != serialized_size() || memcmp(bytes, TOKEN, HEAD)) {
        fail(instance, "these bytes are no state of this FMU");
        return NULL;
    }
    void *content = malloc(sizeof(Content));
    if (content)
        memcpy(content, bytes + HEAD, sizeof(Content));
    return content;
}
