/*
 * Spring by hand: f = lambda n with n = d / |d|, lambda = stiffness (|d| - rest_length) + damping n·u.
 *
 * df/dd = n h^T + c I,  c = lambda / |d|,  h = damping/|d| u + (stiffness - damping/|d| n·u - c) n
 * df/du = damping n n^T
 *
 * Every block of dF/dX is ± df/dd, every block of dF/dV ± df/du.
 */
#include "hand.h"

void hand_spring(const forcec_particle_f64 *p0, const forcec_particle_f64 *p1,
                 const spring_params_f64 *params, spring_out_f64 *out)
{
    const double ks = params->stiffness, kd = params->damping;
    const vec d = sub(load(p1->position), load(p0->position));
    const vec u = sub(load(p1->velocity), load(p0->velocity));
    const double length = sqrt(dot(d, d)), inverse = 1.0 / length;
    const vec n = scale(inverse, d);
    const double rate = dot(n, u);
    const double lambda = ks * (length - params->rest_length) + kd * rate;
    const vec f = scale(lambda, n);
    const double c = lambda * inverse, k = kd * inverse;
    const vec h = add(scale(k, u), scale(ks - k * rate - c, n));
    const vec e = scale(kd, n);

    row6(out->force, f.x, f.y, f.z, -f.x, -f.y, -f.z);

    const double xx = n.x * h.x + c, xy = n.x * h.y, xz = n.x * h.z;
    const double yx = n.y * h.x, yy = n.y * h.y + c, yz = n.y * h.z;
    const double zx = n.z * h.x, zy = n.z * h.y, zz = n.z * h.z + c;
    row6(out->dfdx[0], -xx, -xy, -xz, xx, xy, xz);
    row6(out->dfdx[1], -yx, -yy, -yz, yx, yy, yz);
    row6(out->dfdx[2], -zx, -zy, -zz, zx, zy, zz);
    row6(out->dfdx[3], xx, xy, xz, -xx, -xy, -xz);
    row6(out->dfdx[4], yx, yy, yz, -yx, -yy, -yz);
    row6(out->dfdx[5], zx, zy, zz, -zx, -zy, -zz);

    const double vxx = n.x * e.x, vxy = n.x * e.y, vxz = n.x * e.z;
    const double vyy = n.y * e.y, vyz = n.y * e.z, vzz = n.z * e.z;
    row6(out->dfdv[0], -vxx, -vxy, -vxz, vxx, vxy, vxz);
    row6(out->dfdv[1], -vxy, -vyy, -vyz, vxy, vyy, vyz);
    row6(out->dfdv[2], -vxz, -vyz, -vzz, vxz, vyz, vzz);
    row6(out->dfdv[3], vxx, vxy, vxz, -vxx, -vxy, -vxz);
    row6(out->dfdv[4], vxy, vyy, vyz, -vxy, -vyy, -vyz);
    row6(out->dfdv[5], vxz, vyz, vzz, -vxz, -vyz, -vzz);
}
