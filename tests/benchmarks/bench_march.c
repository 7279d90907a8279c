/* The default valve on its bench in C, which tests/benchmarks/c_program.py compares the march of apesim with.

   It solves the same equations (the EPV paper, doi 10.1631/jzus.A0820373, Eqs. 1 to 8) by the same method: the pair of
   Dormand and Prince of order 5(4), error norm and control of the steps as in apesim/march/adaptive.py, events located
   on the dense output. Laws and events are those of valve/ and apesim/restriction.py, for ideal air and for what the
   motion needs: no effects, ledgers or log, no dry friction. All numbers come from the command line, so that the
   compiler knows none of them. */

#define _POSIX_C_SOURCE 199309L
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { POSITION, SPEED, MASS_A, ENERGY_A, MASS_B, ENERGY_B, STATES };
enum { SUPPLY_A, VENT_A, SUPPLY_B, VENT_B, FLOWS };
enum { MET_CLOSED, MET_OPEN, LEFT, CORNER, FLOW, EVENTS = FLOW + FLOWS };
enum { HELD_CLOSED = 2, TO_CLOSED = 1, TO_OPEN = -1, HELD_OPEN = -2 };
enum { SHUT, NEAR, SUBSONIC, CHOKED }; /* regime of a flow; negative where it runs backwards */

/* Numbers of a run [SI], in the order of the command line. */
struct machine {
    double stroke, moving_mass, piston_area, clearance_volume, spring_rate, viscous_friction;
    double solenoid_area, dead_time, ramp_time, lap;
    double supply_pressure, supply_temperature, vent_pressure, vent_temperature, gas_constant, k;
    double release, end, tolerance, max_step;
};
enum { NUMBERS = sizeof(struct machine) / sizeof(double) };

/* The machine, and what follows from its numbers once. */
struct bench {
    struct machine m;
    double critical, choked_flow, near_flow, near_slope, cp;
};

/* What is constant between events. The energised fraction is x + x_slope (t - start). */
struct mode {
    int phase, regime[FLOWS];
    double start, x, x_slope;
    double low, high; /* lifts between which the groove's area is one line */
};

struct gas { double pressure, temperature; };
struct sides { struct gas before, behind; };

/* fmax and fmin would be calls of a library. */
static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

/* ---- Laws ---- */

static const double NEARLY_EQUAL = 0.999, ROOM = 1e-6, ROOM_TO_TURN = 1e-11;

static double volume_a(const struct machine *m, const double *y) {
    return m->clearance_volume + m->piston_area * y[POSITION];
}

static double volume_b(const struct machine *m, const double *y) {
    return m->clearance_volume + m->piston_area * (m->stroke - y[POSITION]);
}

/* Gas on both sides of each flow; the chambers' pressures stand in sides[VENT_A] and sides[VENT_B], before. */
static void find_sides(const struct machine *m, const double *y, struct sides *sides) {
    struct gas supply = {m->supply_pressure, m->supply_temperature}, vent = {m->vent_pressure, m->vent_temperature};
    double cv = m->gas_constant / (m->k - 1.0);
    struct gas a = {(m->k - 1.0) * y[ENERGY_A] / volume_a(m, y), y[ENERGY_A] / (y[MASS_A] * cv)};
    struct gas b = {(m->k - 1.0) * y[ENERGY_B] / volume_b(m, y), y[ENERGY_B] / (y[MASS_B] * cv)};
    sides[SUPPLY_A] = (struct sides){supply, a}, sides[VENT_A] = (struct sides){a, vent};
    sides[SUPPLY_B] = (struct sides){supply, b}, sides[VENT_B] = (struct sides){b, vent};
}

static double pressure_ratio(int regime, const struct sides *s) {
    return regime > 0 ? s->behind.pressure / s->before.pressure : s->before.pressure / s->behind.pressure;
}

static double subsonic_flow(double ratio, double k) {
    double a = exp(log(ratio) / k);
    return sqrt(2.0 * k / (k - 1.0) * a * (a - ratio));
}

static double flow_function(const struct bench *b, int regime, double ratio) {
    if (regime == CHOKED) return b->choked_flow;
    if (regime == NEAR) return b->near_flow * (1.0 - ratio) / (1.0 - NEARLY_EQUAL);
    if (ratio > NEARLY_EQUAL) return b->near_flow + (ratio - NEARLY_EQUAL) * b->near_slope;
    return subsonic_flow(ratio, b->m.k);
}

/* Mass flow and enthalpy flow through a restriction. */
static void find_flow(const struct bench *b, int regime, double area, const struct sides *s, double *mass, double *h) {
    *mass = *h = 0.0;
    if (regime == SHUT || area <= 0.0) return;
    const struct gas *up = regime > 0 ? &s->before : &s->behind;
    double psi = flow_function(b, abs(regime), pressure_ratio(regime, s));
    *mass = (regime > 0 ? area : -area) * psi * up->pressure / sqrt(b->m.gas_constant * up->temperature);
    *h = *mass * b->cp * up->temperature;
}

static double force(const struct machine *m, const double *y, const struct sides *sides) {
    double pressures = (sides[VENT_A].before.pressure - sides[VENT_B].before.pressure) * m->piston_area;
    return pressures + m->spring_rate * (m->stroke - 2.0 * y[POSITION]) - m->viscous_friction * y[SPEED];
}

static bool is_moving(const struct mode *mode) { return abs(mode->phase) == TO_CLOSED; }

/* Rates of the states; false outside the domain of the laws. */
static bool rates(const struct bench *b, const struct mode *mode, double t, const double *y, double *dy) {
    const struct machine *m = &b->m;
    if (!(y[MASS_A] > 0.0 && y[ENERGY_A] > 0.0 && y[MASS_B] > 0.0 && y[ENERGY_B] > 0.0)) return false;
    if (!(volume_a(m, y) > 0.0 && volume_b(m, y) > 0.0)) return false;

    struct sides sides[FLOWS];
    double mass[FLOWS], h[FLOWS], x = mode->x + mode->x_slope * (t - mode->start);
    double share[FLOWS] = {1.0 - x, x, x, 1.0 - x};
    find_sides(m, y, sides);
    for (int i = 0; i < FLOWS; i++)
        find_flow(b, mode->regime[i], m->solenoid_area * share[i], &sides[i], &mass[i], &h[i]);

    double speed = is_moving(mode) ? y[SPEED] : 0.0;
    dy[POSITION] = speed;
    dy[SPEED] = is_moving(mode) ? force(m, y, sides) / m->moving_mass : 0.0;
    dy[MASS_A] = mass[SUPPLY_A] - mass[VENT_A];
    dy[ENERGY_A] = h[SUPPLY_A] - h[VENT_A] - sides[VENT_A].before.pressure * m->piston_area * speed;
    dy[MASS_B] = mass[SUPPLY_B] - mass[VENT_B];
    dy[ENERGY_B] = h[SUPPLY_B] - h[VENT_B] + sides[VENT_B].before.pressure * m->piston_area * speed;
    return true;
}

/* ---- Events ---- */

static int regime_between(const struct bench *b, const struct sides *s) {
    int direction = s->before.pressure >= s->behind.pressure ? 1 : -1;
    double ratio = pressure_ratio(direction, s);
    return direction * (ratio > NEARLY_EQUAL ? NEAR : ratio > b->critical ? SUBSONIC : CHOKED);
}

/* How far the ratio of pressures lies below and above the regime of a flow. */
static void beyond_ends(const struct bench *b, int regime, const struct sides *s, double *below, double *above) {
    double ratio = pressure_ratio(regime, s);
    int kind = abs(regime);
    *below = (kind == NEAR ? NEARLY_EQUAL : kind == SUBSONIC ? b->critical : -INFINITY) - ratio;
    *above = ratio - (kind == NEAR ? 1.0 : kind == SUBSONIC ? NEARLY_EQUAL : b->critical);
}

/* Values that rise above zero where something happens. */
static void find_events(const struct bench *b, const struct mode *mode, const double *y, double *g) {
    struct sides sides[FLOWS];
    double below, above, lift = b->m.stroke - y[POSITION];
    find_sides(&b->m, y, sides);
    for (int i = 0; i < EVENTS; i++) g[i] = -1.0;
    if (is_moving(mode)) {
        g[MET_CLOSED] = -lift;
        g[MET_OPEN] = -y[POSITION];
        g[CORNER] = larger(mode->low - lift, lift - mode->high);
    } else {
        g[LEFT] = mode->phase == HELD_CLOSED ? -force(&b->m, y, sides) : force(&b->m, y, sides);
    }
    for (int i = 0; i < FLOWS; i++) {
        if (mode->regime[i] == SHUT) continue;
        beyond_ends(b, mode->regime[i], &sides[i], &below, &above);
        g[FLOW + i] = larger(below - ROOM, above - (abs(mode->regime[i]) == NEAR ? ROOM_TO_TURN : ROOM));
    }
}

/* Piece of the groove's area in which a lift lies: steps of apesim end at its corners, too. */
static void take_piece(const struct machine *m, struct mode *mode, double lift) {
    mode->low = lift > m->stroke ? m->stroke : lift > m->lap ? m->lap : -INFINITY;
    mode->high = lift > m->stroke ? INFINITY : lift > m->lap ? m->stroke : m->lap;
}

static void handle_event(const struct bench *b, struct mode *mode, int event, double *y) {
    struct sides sides[FLOWS];
    double lift = b->m.stroke - y[POSITION], below, above;
    if (event == MET_CLOSED || event == MET_OPEN) {
        y[POSITION] = event == MET_CLOSED ? b->m.stroke : 0.0, y[SPEED] = 0.0;
        mode->phase = event == MET_CLOSED ? HELD_CLOSED : HELD_OPEN;
    } else if (event == LEFT) {
        mode->phase = mode->phase == HELD_CLOSED ? TO_OPEN : TO_CLOSED;
    } else if (event == CORNER) {
        bool rising = lift - mode->high > mode->low - lift;
        take_piece(&b->m, mode, rising ? nextafter(mode->high, INFINITY) : mode->low);
    } else {
        int i = event - FLOW, regime = mode->regime[i], direction = regime > 0 ? 1 : -1;
        find_sides(&b->m, y, sides);
        beyond_ends(b, regime, &sides[i], &below, &above);
        int lower = abs(regime) == NEAR && above >= below ? -regime : regime - direction;
        mode->regime[i] = above < below ? regime + direction : lower;
    }
}

/* Energised fraction: dead time and ramp after the edges at 0 and at the release. */
static double energised(const struct machine *m, double t) {
    double up = (t - m->dead_time) / m->ramp_time, down = (t - m->release - m->dead_time) / m->ramp_time;
    return smaller(1.0, larger(0.0, up)) - smaller(1.0, larger(0.0, down));
}

static void start_segment(const struct bench *b, struct mode *mode, double t, double t_end, const double *y) {
    struct sides sides[FLOWS];
    double x = energised(&b->m, t), x_end = energised(&b->m, t_end);
    double share[FLOWS] = {1.0 - x, x, x, 1.0 - x}, share_end[FLOWS] = {1.0 - x_end, x_end, x_end, 1.0 - x_end};
    take_piece(&b->m, mode, b->m.stroke - y[POSITION]);
    mode->start = t, mode->x = x, mode->x_slope = (x_end - x) / (t_end - t);
    find_sides(&b->m, y, sides);
    for (int i = 0; i < FLOWS; i++)
        mode->regime[i] = share[i] > 0.0 || share_end[i] > 0.0 ? regime_between(b, &sides[i]) : SHUT;
}

/* ---- March ---- */

/* A step of the pair of Dormand and Prince; k[0] is given, k[6] ends as the rates of the new state. */
static bool take_step(const struct bench *b, const struct mode *mode, double t, double h, const double *y,
                      double k[7][STATES], double *trial) {
    static const double at[7] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
    static const double w[7][6] = {
        {0.0},
        {1.0 / 5.0},
        {3.0 / 40.0, 9.0 / 40.0},
        {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
        {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
        {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
        {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
#pragma GCC unroll 6
    for (int s = 1; s < 7; s++) {
        for (int i = 0; i < STATES; i++) {
            double sum = w[s][0] * k[0][i];
#pragma GCC unroll 6
            for (int j = 1; j < s; j++) sum += w[s][j] * k[j][i];
            trial[i] = y[i] + h * sum;
        }
        if (!rates(b, mode, t + at[s] * h, trial, k[s])) return false;
    }
    return true;
}

/* Error of a step over its tolerance. */
static double step_error(double tolerance, double h, const double *y, const double *trial, double k[7][STATES]) {
    static const double scale[STATES] = {9e-3, 1.0, 1e-30, 1e-30, 1e-30, 1e-30};
    double total = 0.0;
    for (int i = 0; i < STATES; i++) {
        double e = h * (71.0 / 57600.0 * k[0][i] - 71.0 / 16695.0 * k[2][i] + 71.0 / 1920.0 * k[3][i] -
                        17253.0 / 339200.0 * k[4][i] + 22.0 / 525.0 * k[5][i] - 1.0 / 40.0 * k[6][i]);
        double ratio = e / (tolerance * (scale[i] + larger(fabs(y[i]), fabs(trial[i]))));
        total += ratio * ratio;
    }
    return sqrt(total / STATES);
}

/* Coefficients of the dense output of a step. */
static void interpolate(double h, const double *y, const double *trial, double k[7][STATES], double c[5][STATES]) {
    for (int i = 0; i < STATES; i++) {
        double rise = trial[i] - y[i], bend = h * k[0][i] - rise;
        c[0][i] = y[i], c[1][i] = rise, c[2][i] = bend, c[3][i] = rise - h * k[6][i] - bend;
        c[4][i] = h * (-12715105075.0 / 11282082432.0 * k[0][i] + 87487479700.0 / 32700410799.0 * k[2][i] -
                       10690763975.0 / 1880347072.0 * k[3][i] + 701980252875.0 / 199316789632.0 * k[4][i] -
                       1453857185.0 / 822651844.0 * k[5][i] + 69997945.0 / 29380423.0 * k[6][i]);
    }
}

/* Value of an event at the share x of a step. */
static double value(const struct bench *b, const struct mode *mode, int event, double c[5][STATES], double x) {
    double y[STATES], g[EVENTS], u = 1.0 - x;
    for (int i = 0; i < STATES; i++) y[i] = c[0][i] + x * (c[1][i] + u * (c[2][i] + x * (c[3][i] + u * c[4][i])));
    find_events(b, mode, y, g);
    return g[event];
}

/* Share of a step at which an event happens, by the Illinois method with a bisection in every fourth iteration. */
static double root(const struct bench *b, const struct mode *mode, int event, double h, double c[5][STATES],
                   double f_end) {
    double low = 0.0, high = 1.0, f_low = value(b, mode, event, c, low), f_high = f_end;
    for (double x = 0.5; f_low >= 0.0 && x > 1e-12; x *= 0.5) {
        double f = value(b, mode, event, c, x);
        if (f < 0.0) low = x, f_low = f;
    }
    if (f_low >= 0.0) return 0.0;
    for (int i = 0, side = 0; i < 100 && (high - low) * h >= 1e-12; i++) {
        double x = i % 4 == 3 ? 0.5 * (low + high) : (low * f_high - high * f_low) / (f_high - f_low);
        if (!(low < x && x < high)) x = 0.5 * (low + high);
        double f = value(b, mode, event, c, x);
        if (f == 0.0) return x;
        if (f > 0.0) {
            high = x, f_high = f, f_low *= side == 1 ? 0.5 : 1.0, side = 1;
        } else {
            low = x, f_low = f, f_high *= side == -1 ? 0.5 : 1.0, side = -1;
        }
    }
    return high;
}

struct outcome {
    int steps, rejected, evaluations, events, contacts; /* steps are negative where it failed */
    double contact[8];
};

/* March from t = 0 to the end; y ends as the state there. */
static __attribute__((noinline)) struct outcome march(const struct bench *b, double *y) {
    const struct machine *m = &b->m;
    const double ready = m->dead_time + m->ramp_time, off = m->release;
    const double breakpoints[6] = {m->dead_time, ready, off, off + m->dead_time, off + ready, m->end};
    double k[7][STATES], c[5][STATES], trial[STATES], g[EVENTS];
    double t = 0.0, h_next = 0.05 * m->max_step, last_error = 1e-4;
    struct mode mode = {.phase = HELD_CLOSED};
    struct outcome o = {0};

    for (int stretch = 0; stretch < 6; stretch++) {
        start_segment(b, &mode, t, breakpoints[stretch], y);
        rates(b, &mode, t, y, k[0]);
        while (t < breakpoints[stretch]) {
            double whole = breakpoints[stretch] - t, h = smaller(h_next, m->max_step);
            if (h > 0.5 * whole) h = h >= whole ? whole : 0.5 * whole;
            if ((h < 1e-14 && h < whole) || o.events > 2000) return o.steps = -1, o;

            /* A step, rejected where it leaves the domain of the laws or errs by more than the tolerance. */
            o.evaluations += 6;
            if (!take_step(b, &mode, t, h, y, k, trial)) {
                o.rejected++, h_next = 0.25 * h;
                continue;
            }
            double error = step_error(m->tolerance, h, y, trial, k);
            if (!(error <= 1.0)) {
                o.rejected++, h_next = error < 1e300 ? h * larger(0.2, 0.9 * pow(error, -0.2)) : 0.1 * h;
                continue;
            }
            double growth = 0.9 * pow(larger(error, 1e-10), -0.17) * pow(last_error, 0.04);
            double grown = h * smaller(5.0, larger(0.2, growth));
            h_next = h == whole ? larger(grown, h_next) : grown;
            last_error = larger(error, 1e-4);

            /* The first event within it, up to which the step is made again. */
            int event = -1;
            double share = 2.0, end = h == whole ? breakpoints[stretch] : t + h;
            bool hit = false;
            find_events(b, &mode, trial, g);
            for (int i = 0; i < EVENTS; i++) hit |= g[i] > 0.0;
            if (hit) {
                interpolate(h, y, trial, k, c);
                for (int i = 0; i < EVENTS; i++) {
                    double x = g[i] > 0.0 ? root(b, &mode, i, h, c, g[i]) : 2.0;
                    if (x < share) event = i, share = x;
                }
                h *= share, end = t + h, o.evaluations += 6;
                if (!take_step(b, &mode, t, h, y, k, trial) || step_error(m->tolerance, h, y, trial, k) > 10.0) {
                    o.rejected++, h_next = 0.5 * h;
                    continue;
                }
            }
            o.steps++, t = end;
            memcpy(y, trial, sizeof trial);
            if (event < 0) {
                memcpy(k[0], k[6], sizeof k[0]);
                continue;
            }
            o.events++;
            if (event <= MET_OPEN && o.contacts < 8) o.contact[o.contacts++] = t;
            handle_event(b, &mode, event, y);
            rates(b, &mode, t, y, k[0]);
        }
    }
    return o;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int count, char **given) {
    struct bench b;
    double numbers[NUMBERS];
    if (count != NUMBERS + 2) return fprintf(stderr, "wants %d numbers, and how often to march\n", (int)NUMBERS), 2;
    for (int i = 0; i < (int)NUMBERS; i++) numbers[i] = strtod(given[i + 1], NULL);
    memcpy(&b.m, numbers, sizeof b.m);
    const struct machine *m = &b.m;
    const double k = m->k, a = exp(log(NEARLY_EQUAL) / k);
    b.critical = pow(2.0 / (k + 1.0), k / (k - 1.0));
    b.choked_flow = pow(2.0 / (k + 1.0), 1.0 / (k - 1.0)) * sqrt(2.0 * k / (k + 1.0));
    b.near_flow = subsonic_flow(NEARLY_EQUAL, k);
    b.near_slope = 0.5 * b.near_flow * ((2.0 * a / NEARLY_EQUAL - 1.0) / k - 1.0) / (a - NEARLY_EQUAL);
    b.cp = k / (k - 1.0) * m->gas_constant;

    /* Closed and at rest, chamber A filled by the supply, chamber B vented. */
    double start[STATES] = {[POSITION] = m->stroke}, y[STATES];
    start[ENERGY_A] = m->supply_pressure * volume_a(m, start) / (k - 1.0);
    start[ENERGY_B] = m->vent_pressure * volume_b(m, start) / (k - 1.0);
    start[MASS_A] = start[ENERGY_A] * (k - 1.0) / (m->gas_constant * m->supply_temperature);
    start[MASS_B] = start[ENERGY_B] * (k - 1.0) / (m->gas_constant * m->supply_temperature);

    struct outcome o = {0};
    double seconds = DBL_MAX;
    for (int i = atoi(given[count - 1]); i > 0; i--) {
        memcpy(y, start, sizeof y);
        double begin = now();
        o = march(&b, y);
        seconds = smaller(seconds, now() - begin);
    }
    printf("{\"seconds\": %.9g, \"steps\": %d, \"rejected\": %d, \"evaluations\": %d, \"contacts\": [", seconds, o.steps,
           o.rejected, o.evaluations);
    for (int i = 0; i < o.contacts; i++) printf("%s%.15g", i ? ", " : "", o.contact[i]);
    printf("]}\n");
    return o.steps < 0;
}
