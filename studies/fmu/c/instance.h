/* An instance of the model: what both versions of FMI have in common. */

#ifndef APESIM_INSTANCE_H
#define APESIM_INSTANCE_H

#include <stddef.h>
#include <stdint.h>

#include "model.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef enum { INSTANTIATED, INITIALIZING, STEPPING, EVENTS, TERMINATED, FAILED } Mode;
typedef enum { TIME, INPUT, OUTPUT, PARAMETER, CONSTANT, UNKNOWN } Kind;

/* All that changes: copied as a whole for the state of the FMU. */
typedef struct {
    double numbers[NUMBER_COUNT];
    double parameters[PARAMETER_COUNT + 1];
    double inputs[INPUT_COUNT];
    double outputs[OUTPUT_COUNT];
    double state[STATE_SIZE];
    double time;
    int64_t mode;
    int64_t is_new; /* parameters or inputs were set since the outputs were computed, before the first step */
} Content;

typedef struct Instance Instance;
typedef void (*Report)(Instance *instance, const char *text);

struct Instance {
    Content content;
    Report report;
    void *environment;
    void (*logger)(void);
    char *name;
};

Instance *new_instance(const char *name, const char *token, Report report, void *environment, void (*logger)(void));
void free_instance(Instance *instance);
void reset_instance(Instance *instance);
void fail(Instance *instance, const char *format, ...);

/* Each returns whether all went well; what is wrong has been reported. */
int may(Instance *instance, const char *function, unsigned modes);
int begin(Instance *instance, double start);
int finish_initialization(Instance *instance);
int advance(Instance *instance, double from, double duration);
int read_value(Instance *instance, unsigned reference, int is_whole, double *value);
int write_value(Instance *instance, unsigned reference, int is_whole, double value);

void *copy_content(const Instance *instance);
size_t serialized_size(void);
int serialize(Instance *instance, const void *content, unsigned char *bytes, size_t size);
void *deserialize(Instance *instance, const unsigned char *bytes, size_t size);

#define IN(mode) (1u << (mode))

#endif
