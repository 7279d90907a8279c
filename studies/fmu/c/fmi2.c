/* FMI 2.0 for co-simulation: the functions of the standard, with its types as far as they are needed. */

#include <stdlib.h>
#include <string.h>

#include "instance.h"

typedef void *fmi2Component;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*Logger)(void *, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef struct {
    Logger logger;
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(void *, fmi2Status);
    void *componentEnvironment;
} fmi2CallbackFunctions;

#define FMI2(name, ...) EXPORT fmi2Status fmi2##name(fmi2Component c, ##__VA_ARGS__)
#define BEFORE_END (IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING))
#define ANY_TIME (BEFORE_END | IN(TERMINATED))
#define CHECK(name, modes) \
    if (!may(c, "fmi2" #name, modes)) \
        return fmi2Error

static fmi2Status status_of(int is_well) { return is_well ? fmi2OK : fmi2Error; }

static void report(Instance *instance, const char *text)
{
    if (instance->logger)
        ((Logger)instance->logger)(instance->environment, instance->name, fmi2Error, "logStatusError", "%s", text);
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                     fmi2Boolean logging_on)
{
    (void)resources, (void)visible, (void)logging_on;
    Logger logger = functions ? functions->logger : NULL;
    void *environment = functions ? functions->componentEnvironment : NULL;
    if (type != fmi2CoSimulation) {
        if (logger)
            logger(environment, name, fmi2Error, "logStatusError", "this FMU is for co-simulation");
        return NULL;
    }
    return new_instance(name, guid, report, environment, (void (*)(void))logger);
}

EXPORT void fmi2FreeInstance(fmi2Component c) { free_instance(c); }

FMI2(SetDebugLogging, fmi2Boolean logging_on, size_t count, const fmi2String categories[])
{
    (void)logging_on, (void)count, (void)categories; /* errors are always told, and there is nothing else */
    return status_of(c != NULL);
}

FMI2(SetupExperiment, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start, fmi2Boolean has_stop,
     fmi2Real stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    CHECK(SetupExperiment, IN(INSTANTIATED));
    ((Instance *)c)->content.time = start;
    return fmi2OK;
}

FMI2(EnterInitializationMode)
{
    CHECK(EnterInitializationMode, IN(INSTANTIATED));
    return status_of(begin(c, ((Instance *)c)->content.time));
}

FMI2(ExitInitializationMode)
{
    CHECK(ExitInitializationMode, IN(INITIALIZING));
    return status_of(finish_initialization(c));
}

FMI2(Terminate)
{
    CHECK(Terminate, IN(STEPPING) | IN(FAILED));
    ((Instance *)c)->content.mode = TERMINATED;
    return fmi2OK;
}

FMI2(Reset)
{
    if (!c)
        return fmi2Error;
    reset_instance(c);
    return fmi2OK;
}

FMI2(GetReal, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    CHECK(GetReal, ANY_TIME);
    for (size_t i = 0; i < count; i++)
        if (!read_value(c, references[i], 0, &values[i]))
            return fmi2Error;
    return fmi2OK;
}

FMI2(GetInteger, const fmi2ValueReference references[], size_t count, fmi2Integer values[])
{
    CHECK(GetInteger, ANY_TIME);
    for (size_t i = 0; i < count; i++) {
        double value;
        if (!read_value(c, references[i], 1, &value))
            return fmi2Error;
        values[i] = (fmi2Integer)value;
    }
    return fmi2OK;
}

FMI2(SetReal, const fmi2ValueReference references[], size_t count, const fmi2Real values[])
{
    CHECK(SetReal, BEFORE_END);
    for (size_t i = 0; i < count; i++)
        if (!write_value(c, references[i], 0, values[i]))
            return fmi2Error;
    return fmi2OK;
}

FMI2(SetInteger, const fmi2ValueReference references[], size_t count, const fmi2Integer values[])
{
    CHECK(SetInteger, BEFORE_END);
    for (size_t i = 0; i < count; i++)
        if (!write_value(c, references[i], 1, values[i]))
            return fmi2Error;
    return fmi2OK;
}

/* No variable is a Boolean or a String. */
static fmi2Status none_of(fmi2Component c, size_t count, const char *type)
{
    if (c && count > 0)
        fail(c, "there is no variable of the type %s", type);
    return status_of(c && count == 0);
}

FMI2(GetBoolean, const fmi2ValueReference references[], size_t count, fmi2Boolean values[])
{
    (void)references, (void)values;
    return none_of(c, count, "Boolean");
}

FMI2(SetBoolean, const fmi2ValueReference references[], size_t count, const fmi2Boolean values[])
{
    (void)references, (void)values;
    return none_of(c, count, "Boolean");
}

FMI2(GetString, const fmi2ValueReference references[], size_t count, fmi2String values[])
{
    (void)references, (void)values;
    return none_of(c, count, "String");
}

FMI2(SetString, const fmi2ValueReference references[], size_t count, const fmi2String values[])
{
    (void)references, (void)values;
    return none_of(c, count, "String");
}

FMI2(GetFMUstate, fmi2FMUstate *state)
{
    if (!c || !state)
        return fmi2Error;
    free(*state);
    *state = copy_content(c);
    return status_of(*state != NULL);
}

FMI2(SetFMUstate, fmi2FMUstate state)
{
    if (!c || !state)
        return fmi2Error;
    memcpy(&((Instance *)c)->content, state, sizeof(Content));
    return fmi2OK;
}

FMI2(FreeFMUstate, fmi2FMUstate *state)
{
    if (!c)
        return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

FMI2(SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
{
    if (!c || !state)
        return fmi2Error;
    *size = serialized_size();
    return fmi2OK;
}

FMI2(SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return status_of(c && state && serialize(c, state, (unsigned char *)bytes, size));
}

FMI2(DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    if (!c || !bytes || !state)
        return fmi2Error;
    free(*state);
    *state = deserialize(c, (const unsigned char *)bytes, size);
    return status_of(*state != NULL);
}

static fmi2Status not_there(fmi2Component c, const char *function)
{
    if (c)
        fail(c, "%s: this FMU does not have it", function);
    return fmi2Error;
}

FMI2(GetDirectionalDerivative, const fmi2ValueReference unknowns[], size_t unknown_count,
     const fmi2ValueReference knowns[], size_t known_count, const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)sensitivity;
    return not_there(c, "fmi2GetDirectionalDerivative");
}

FMI2(SetRealInputDerivatives, const fmi2ValueReference references[], size_t count, const fmi2Integer order[],
     const fmi2Real values[])
{
    (void)references, (void)count, (void)order, (void)values;
    return not_there(c, "fmi2SetRealInputDerivatives");
}

FMI2(GetRealOutputDerivatives, const fmi2ValueReference references[], size_t count, const fmi2Integer order[],
     fmi2Real values[])
{
    (void)references, (void)count, (void)order, (void)values;
    return not_there(c, "fmi2GetRealOutputDerivatives");
}

FMI2(DoStep, fmi2Real from, fmi2Real duration, fmi2Boolean is_final)
{
    (void)is_final;
    CHECK(DoStep, IN(STEPPING));
    return status_of(advance(c, from, duration));
}

FMI2(CancelStep)
{
    return not_there(c, "fmi2CancelStep");
}

FMI2(GetStatus, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value; /* steps are never pending */
    return c ? fmi2Discard : fmi2Error;
}

FMI2(GetRealStatus, const fmi2StatusKind kind, fmi2Real *value)
{
    if (!c || kind != fmi2LastSuccessfulTime)
        return c ? fmi2Discard : fmi2Error;
    *value = ((Instance *)c)->content.time;
    return fmi2OK;
}

FMI2(GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return c ? fmi2Discard : fmi2Error;
}

FMI2(GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (!c || kind != fmi2Terminated)
        return c ? fmi2Discard : fmi2Error;
    *value = 0;
    return fmi2OK;
}

FMI2(GetStringStatus, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return c ? fmi2Discard : fmi2Error;
}
