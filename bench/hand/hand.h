/*
 * What the kernels written by hand share: vectors of three as scalars, and rows of outputs stored in order.
 */
#ifndef HAND_H
#define HAND_H

#include "joints.h"
#include "springs.h"

typedef struct { double x, y, z; } vec;

static inline vec load(const double *v)
{
    return (vec){ v[0], v[1], v[2] };
}

static inline vec sub(vec a, vec b)
{
    return (vec){ a.x - b.x, a.y - b.y, a.z - b.z };
}

static inline vec add(vec a, vec b)
{
    return (vec){ a.x + b.x, a.y + b.y, a.z + b.z };
}

static inline vec scale(double s, vec a)
{
    return (vec){ s * a.x, s * a.y, s * a.z };
}

static inline double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec cross(vec a, vec b)
{
    return (vec){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

/* v + 2 q_w (q × v) + 2 q × (q × v) */
static inline vec rotate(const double *q, vec v)
{
    const vec i = { q[0], q[1], q[2] };
    const vec t = cross(i, v);
    const vec s = { t.x + t.x, t.y + t.y, t.z + t.z };
    return add(add(v, scale(q[3], s)), cross(i, s));
}

static inline void row6(double *to, double e0, double e1, double e2, double e3, double e4, double e5)
{
    to[0] = e0, to[1] = e1, to[2] = e2, to[3] = e3, to[4] = e4, to[5] = e5;
}

static inline void row12(double *to, double e0, double e1, double e2, double e3, double e4, double e5,
                         double e6, double e7, double e8, double e9, double e10, double e11)
{
    to[0] = e0, to[1] = e1, to[2] = e2, to[3] = e3, to[4] = e4, to[5] = e5;
    to[6] = e6, to[7] = e7, to[8] = e8, to[9] = e9, to[10] = e10, to[11] = e11;
}

void hand_point_to_point(const forcec_rigid_f64 *a, const forcec_rigid_f64 *b,
                         const point_to_point_params_f64 *params, point_to_point_out_f64 *out);
void hand_distance(const forcec_rigid_f64 *a, const forcec_rigid_f64 *b,
                   const distance_params_f64 *params, distance_out_f64 *out);
void hand_spring(const forcec_particle_f64 *p0, const forcec_particle_f64 *p1,
                 const spring_params_f64 *params, spring_out_f64 *out);

#endif
