/* A host that is not Python: runs the valve's FMU with a pulse of 50 ms, and prints the lift [m] at each step. */
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
#define dlopen(path, flags) (void *)LoadLibraryA(path)
#define dlsym(library, name) (void *)GetProcAddress(library, name)
#define dlerror() "the library does not load"
#else
#include <dlfcn.h>
#endif

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger logger; void *memory[3], *environment; } Callbacks;
static void logger(void *e, const char *name, int status, const char *category, const char *text, ...) { puts(text); }

int main(int count, char **words) /* library, token, steps, length of a step [s] */
{
    void *library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return fputs(dlerror(), stderr), 1;
    void *(*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) =
        dlsym(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = dlsym(library, "fmi2SetupExperiment");
    int (*enter)(void *) = dlsym(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = dlsym(library, "fmi2ExitInitializationMode");
    int (*set)(void *, const unsigned *, size_t, const int *) = dlsym(library, "fmi2SetInteger");
    int (*get)(void *, const unsigned *, size_t, double *) = dlsym(library, "fmi2GetReal");
    int (*step)(void *, double, double, int) = dlsym(library, "fmi2DoStep");
    void (*end)(void *) = dlsym(library, "fmi2FreeInstance");
    Callbacks callbacks = {logger};
    const unsigned command = 1, lift = 4;
    double length = atof(words[4]), value;
    void *valve = instantiate("valve", 1, words[2], "", &callbacks, 0, 0);
    if (!valve || setup(valve, 0, 0.0, 0.0, 0, 0.0) || enter(valve) || leave(valve))
        return 2;
    for (int i = 0, steps = atoi(words[3]); i < steps; i++) {
        int energised = i * length < 0.05 - 1e-9;
        if (set(valve, &command, 1, &energised) || step(valve, i * length, length, 1) || get(valve, &lift, 1, &value))
            return 3;
        printf("%.17g\n", value);
    }
    return end(valve), 0;
}
