/* FMI 3.0 for co-simulation: the functions of the standard, with its types as far as they are needed. */

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef int fmi3DependencyKind;
typedef int fmi3IntervalQualifier;
typedef void (*Logger)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);

#define FMI3(name, ...) EXPORT fmi3Status fmi3##name(fmi3Instance c, ##__VA_ARGS__)
#define REFERENCES const fmi3ValueReference references[], size_t count
#define BEFORE_END (IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING))
#define ANY_TIME (BEFORE_END | IN(TERMINATED))
#define CHECK(name, modes) \
    if (!may(c, "fmi3" #name, modes)) \
        return fmi3Error

static fmi3Status status_of(int is_well) { return is_well ? fmi3OK : fmi3Error; }

static void report(Instance *instance, const char *text)
{
    if (instance->logger)
        ((Logger)instance->logger)(instance->environment, fmi3Error, "logStatusError", text);
}

static fmi3Status not_there(fmi3Instance c, const char *function)
{
    if (c)
        fail(c, "%s: this FMU does not have it", function);
    return fmi3Error;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                fmi3Boolean visible, fmi3Boolean logging_on,
                                                fmi3Boolean event_mode_used, fmi3Boolean early_return_allowed,
                                                const fmi3ValueReference required[], size_t required_count,
                                                fmi3InstanceEnvironment environment, Logger logger, void (*update)(void))
{
    (void)resources, (void)visible, (void)logging_on, (void)early_return_allowed;
    (void)required, (void)required_count, (void)update;
    if (event_mode_used) {
        if (logger)
            logger(environment, fmi3Error, "logStatusError", "this FMU has no event mode");
        return NULL;
    }
    return new_instance(name, token, report, environment, (void (*)(void))logger);
}

EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                 fmi3Boolean visible, fmi3Boolean logging_on,
                                                 fmi3InstanceEnvironment environment, Logger logger)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging_on;
    if (logger)
        logger(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation");
    return NULL;
}

EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging_on,
                                                      fmi3InstanceEnvironment environment, Logger logger,
                                                      void (*update)(void), void (*lock)(void), void (*unlock)(void))
{
    (void)update, (void)lock, (void)unlock;
    return fmi3InstantiateModelExchange(name, token, resources, visible, logging_on, environment, logger);
}

EXPORT void fmi3FreeInstance(fmi3Instance c) { free_instance(c); }

FMI3(SetDebugLogging, fmi3Boolean logging_on, size_t count, const fmi3String categories[])
{
    (void)logging_on, (void)count, (void)categories; /* errors are always told, and there is nothing else */
    return status_of(c != NULL);
}

FMI3(EnterInitializationMode, fmi3Boolean has_tolerance, fmi3Float64 tolerance, fmi3Float64 start,
     fmi3Boolean has_stop, fmi3Float64 stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    CHECK(EnterInitializationMode, IN(INSTANTIATED));
    return status_of(begin(c, start));
}

FMI3(ExitInitializationMode)
{
    CHECK(ExitInitializationMode, IN(INITIALIZING));
    return status_of(finish_initialization(c));
}

FMI3(Terminate)
{
    CHECK(Terminate, IN(STEPPING) | IN(FAILED));
    ((Instance *)c)->content.mode = TERMINATED;
    return fmi3OK;
}

FMI3(Reset)
{
    if (!c)
        return fmi3Error;
    reset_instance(c);
    return fmi3OK;
}

static int is_complete(fmi3Instance c, size_t count, size_t value_count)
{
    if (count == value_count)
        return 1;
    fail(c, "%zu values for %zu variables, each of which has one", value_count, count);
    return 0;
}

FMI3(GetFloat64, REFERENCES, fmi3Float64 values[], size_t value_count)
{
    CHECK(GetFloat64, ANY_TIME);
    int is_well = is_complete(c, count, value_count);
    for (size_t i = 0; is_well && i < count; i++)
        is_well = read_value(c, references[i], 0, &values[i]);
    return status_of(is_well);
}

FMI3(SetFloat64, REFERENCES, const fmi3Float64 values[], size_t value_count)
{
    CHECK(SetFloat64, BEFORE_END);
    int is_well = is_complete(c, count, value_count);
    for (size_t i = 0; is_well && i < count; i++)
        is_well = write_value(c, references[i], 0, values[i]);
    return status_of(is_well);
}

FMI3(GetInt32, REFERENCES, fmi3Int32 values[], size_t value_count)
{
    CHECK(GetInt32, ANY_TIME);
    int is_well = is_complete(c, count, value_count);
    for (size_t i = 0; is_well && i < count; i++) {
        double value = 0.0;
        is_well = read_value(c, references[i], 1, &value);
        values[i] = (fmi3Int32)value;
    }
    return status_of(is_well);
}

FMI3(SetInt32, REFERENCES, const fmi3Int32 values[], size_t value_count)
{
    CHECK(SetInt32, BEFORE_END);
    int is_well = is_complete(c, count, value_count);
    for (size_t i = 0; is_well && i < count; i++)
        is_well = write_value(c, references[i], 1, values[i]);
    return status_of(is_well);
}

/* No variable is of any other type. */
static fmi3Status none_of(fmi3Instance c, size_t count, const char *type)
{
    if (c && count > 0)
        fail(c, "there is no variable of the type %s", type);
    return status_of(c && count == 0);
}

#define NO_VARIABLES(type) \
    FMI3(Get##type, REFERENCES, fmi3##type values[], size_t value_count) \
    { \
        (void)references, (void)values, (void)value_count; \
        return none_of(c, count, #type); \
    } \
    FMI3(Set##type, REFERENCES, const fmi3##type values[], size_t value_count) \
    { \
        (void)references, (void)values, (void)value_count; \
        return none_of(c, count, #type); \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

FMI3(GetBinary, REFERENCES, size_t sizes[], fmi3Binary values[], size_t value_count)
{
    (void)references, (void)sizes, (void)values, (void)value_count;
    return none_of(c, count, "Binary");
}

FMI3(SetBinary, REFERENCES, const size_t sizes[], const fmi3Binary values[], size_t value_count)
{
    (void)references, (void)sizes, (void)values, (void)value_count;
    return none_of(c, count, "Binary");
}

FMI3(GetClock, REFERENCES, fmi3Clock values[])
{
    (void)references, (void)values;
    return none_of(c, count, "Clock");
}

FMI3(SetClock, REFERENCES, const fmi3Clock values[])
{
    (void)references, (void)values;
    return none_of(c, count, "Clock");
}

FMI3(GetFMUState, fmi3FMUState *state)
{
    if (!c || !state)
        return fmi3Error;
    free(*state);
    *state = copy_content(c);
    return status_of(*state != NULL);
}

FMI3(SetFMUState, fmi3FMUState state)
{
    if (!c || !state)
        return fmi3Error;
    memcpy(&((Instance *)c)->content, state, sizeof(Content));
    return fmi3OK;
}

FMI3(FreeFMUState, fmi3FMUState *state)
{
    if (!c)
        return fmi3Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMI3(SerializedFMUStateSize, fmi3FMUState state, size_t *size)
{
    if (!c || !state)
        return fmi3Error;
    *size = serialized_size();
    return fmi3OK;
}

FMI3(SerializeFMUState, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return status_of(c && state && serialize(c, state, bytes, size));
}

FMI3(DeserializeFMUState, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (!c || !bytes || !state)
        return fmi3Error;
    free(*state);
    *state = deserialize(c, bytes, size);
    return status_of(*state != NULL);
}

FMI3(EnterStepMode)
{
    CHECK(EnterStepMode, IN(STEPPING));
    return fmi3OK;
}

FMI3(DoStep, fmi3Float64 from, fmi3Float64 duration, fmi3Boolean is_final, fmi3Boolean *event_needed,
     fmi3Boolean *is_terminated, fmi3Boolean *is_early, fmi3Float64 *last_time)
{
    (void)is_final;
    CHECK(DoStep, IN(STEPPING));
    int is_well = advance(c, from, duration);
    *event_needed = *is_terminated = *is_early = false;
    *last_time = ((Instance *)c)->content.time;
    return status_of(is_well);
}

/* What co-simulation without events, clocks, derivatives and structural parameters does not need. */
#define NOT_THERE(name, ...) \
    FMI3(name, ##__VA_ARGS__) { return not_there(c, "fmi3" #name); }

#pragma GCC diagnostic ignored "-Wunused-parameter"
NOT_THERE(EnterEventMode)
NOT_THERE(EnterConfigurationMode)
NOT_THERE(ExitConfigurationMode)
NOT_THERE(GetNumberOfVariableDependencies, fmi3ValueReference reference, size_t *count)
NOT_THERE(GetVariableDependencies, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
          size_t independent_elements[], fmi3DependencyKind kinds[], size_t count)
NOT_THERE(GetDirectionalDerivative, const fmi3ValueReference unknowns[], size_t unknown_count,
          const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
          fmi3Float64 sensitivity[], size_t sensitivity_count)
NOT_THERE(GetAdjointDerivative, const fmi3ValueReference unknowns[], size_t unknown_count,
          const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
          fmi3Float64 sensitivity[], size_t sensitivity_count)
NOT_THERE(GetIntervalDecimal, REFERENCES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
NOT_THERE(GetIntervalFraction, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
          fmi3IntervalQualifier qualifiers[])
NOT_THERE(GetShiftDecimal, REFERENCES, fmi3Float64 shifts[])
NOT_THERE(GetShiftFraction, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
NOT_THERE(SetIntervalDecimal, REFERENCES, const fmi3Float64 intervals[])
NOT_THERE(SetIntervalFraction, REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_THERE(SetShiftDecimal, REFERENCES, const fmi3Float64 shifts[])
NOT_THERE(SetShiftFraction, REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_THERE(EvaluateDiscreteStates)
NOT_THERE(UpdateDiscreteStates, fmi3Boolean *needs_update, fmi3Boolean *is_terminated, fmi3Boolean *nominals_changed,
          fmi3Boolean *values_changed, fmi3Boolean *has_next, fmi3Float64 *next_time)
NOT_THERE(GetOutputDerivatives, REFERENCES, const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count)
NOT_THERE(ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
NOT_THERE(EnterContinuousTimeMode)
NOT_THERE(CompletedIntegratorStep, fmi3Boolean is_final, fmi3Boolean *enter_events, fmi3Boolean *is_terminated)
NOT_THERE(SetTime, fmi3Float64 time)
NOT_THERE(SetContinuousStates, const fmi3Float64 states[], size_t count)
NOT_THERE(GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t count)
NOT_THERE(GetEventIndicators, fmi3Float64 indicators[], size_t count)
NOT_THERE(GetContinuousStates, fmi3Float64 states[], size_t count)
NOT_THERE(GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t count)
NOT_THERE(GetNumberOfEventIndicators, size_t *count)
NOT_THERE(GetNumberOfContinuousStates, size_t *count)
