/* A cable robot of its own: written from the paper's Eqs. (4), (7), (8), (16) and (21), without
   scdpr_jax. Semi-implicit Euler with many steps in a period; dry friction is an impulse that
   stops a body or slows it, never turns it round. All numbers in SI units. */
#include <math.h>
#include <stddef.h>

typedef struct {
    double pretension, loop_stiffness, lower_friction, upper_friction, static_surplus;
    double inertia, damping, motor_friction, cable_stiffness, cable_damping, backlash;
    double ripple, ripple_waves, air_damping, turning_damping;
} rig_t;

typedef struct {
    double proportional, derivative, period, count, stop_after, rigid, bare;
} loop_t;

static const double HEIGHT = 1.112, ARM = 0.1405, MASS = 2.1, TURNING = 0.025198;
static const double CARRIAGE = 1.2, RADIUS = 0.073, TORQUE = 0.482, LIMIT = 10.0;
static const double STRIBECK = 0.02;

static double slowed(double v, double most) {
    return v > most ? v - most : v < -most ? v + most : 0.0;
}

/* Positions x, delta, q_3, q_4, y, pulley angles and voltages at every period's beginning. */
void rig_run(const rig_t *p, const loop_t *loop, int periods, int substeps, const double *start,
             const double *reference, const double *forward, const double *push,
             double *position, double *angle, double *voltage) {
    double q[5], v[5] = {0}, a[2] = {0}, w[2] = {0}, before[2], volts[2];
    const double dt = loop->period / substeps;
    const int rigid = loop->rigid != 0, bare = loop->bare != 0;
    const double reflected = rigid ? 2 * p->inertia / (RADIUS * RADIUS) : 0.0;
    const double drag = rigid ? 2 * p->damping / (RADIUS * RADIUS) : 0.0;
    int stopped = 0;
    for (int i = 0; i < 5; i++) q[i] = start[i];
    for (int n = 0; n < periods; n++) {
        stopped |= loop->stop_after > 0 && fabs(q[2] - start[2]) > loop->stop_after;
        for (int i = 0; i < 2; i++) {
            double seen = loop->count > 0 ? round(a[i] / loop->count) * loop->count : a[i];
            double error = reference[2 * n + i] - seen;
            if (n == 0) before[i] = error;
            double u = loop->proportional * error + forward[2 * n + i]
                + loop->derivative * (error - before[i]) / loop->period;
            before[i] = error;
            u = stopped ? 0.0 : u;
            volts[i] = u > LIMIT ? LIMIT : u < -LIMIT ? -LIMIT : u;
            voltage[2 * n + i] = volts[i];
            angle[2 * n + i] = a[i];
        }
        for (int i = 0; i < 5; i++) position[5 * n + i] = q[i];
        for (int k = 0; k < substeps; k++) {
            const double s = sin(q[1]), c = cos(q[1]);
            const double lx = q[2] - q[0] - ARM * s, ly = q[4] - ARM * c;
            const double ux = q[0] - q[3] - ARM * s, uy = HEIGHT - q[4] - ARM * c;
            const double ox = q[2] - q[3];
            const double l = sqrt(lx * lx + ly * ly), u = sqrt(ux * ux + uy * uy);
            const double o = sqrt(ox * ox + HEIGHT * HEIGHT);
            const double longer = 2 * (l + u + o - (2 * HEIGHT - 2 * ARM));
            const double T = 2 * (p->pretension + p->loop_stiffness * longer);
            const double sa = lx / l, ca = ly / l, sb = ux / u, cb = uy / u;
            const double so = ox / o, co = HEIGHT / o;
            double drive[2], tau[2];
            for (int i = 0; i < 2; i++)
                tau[i] = TORQUE * volts[i] * (1 + p->ripple * sin(p->ripple_waves * a[i] + i));
            if (rigid && !bare) {
                for (int i = 0; i < 2; i++) drive[i] = tau[i] / RADIUS;
            } else {
                for (int i = 0; i < 2; i++) {
                    const double way = q[2] - start[2] + (i ? -1 : 1) * (q[4] - start[4]);
                    const double pace = v[2] + (i ? -1 : 1) * v[4];
                    double give = RADIUS * a[i] - way;
                    give = slowed(give, p->backlash / 2);
                    drive[i] = bare ? 0.0
                        : p->cable_stiffness * give + p->cable_damping * (RADIUS * w[i] - pace);
                    w[i] += dt * (tau[i] - p->damping * w[i] - RADIUS * drive[i]) / p->inertia;
                    w[i] = slowed(w[i], dt * p->motor_friction / p->inertia);
                    a[i] += dt * w[i];
                }
                if (bare) continue;
            }
            const double knock = push ? push[n] : 0.0;
            v[0] += dt * (T * (sa - sb) + knock - p->air_damping * v[0]) / MASS;
            v[1] += dt * (T * ARM * (sa * c - ca * s + sb * c - cb * s)
                          - p->turning_damping * v[1]) / TURNING;
            v[2] += dt * (drive[0] + drive[1] - T * (sa + so) - drag * v[2])
                / (CARRIAGE + reflected);
            v[3] += dt * T * (sb + so) / CARRIAGE;
            v[4] += dt * (drive[0] - drive[1] - T * (ca - cb) - drag * v[4])
                / (MASS + reflected);
            const double low = 1 + p->static_surplus * exp(-fabs(v[2]) / STRIBECK);
            const double top = 1 + p->static_surplus * exp(-fabs(v[3]) / STRIBECK);
            v[2] = slowed(v[2], dt * p->lower_friction * low * T * (ca + co)
                          / (CARRIAGE + reflected));
            v[3] = slowed(v[3], dt * p->upper_friction * top * T * (cb + co) / CARRIAGE);
            for (int i = 0; i < 5; i++) q[i] += dt * v[i];
            if (rigid) {
                a[0] = (q[2] - start[2] + q[4] - start[4]) / RADIUS;
                a[1] = (q[2] - start[2] - q[4] + start[4]) / RADIUS;
            }
        }
    }
}
