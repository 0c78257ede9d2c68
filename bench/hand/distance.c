/*
 * Distance joint by hand: f = lambda n with n = d / |d|, lambda = stiffness (|d| - rest_length) + damping n·u.
 *
 *   F = (f, ra × f, -f, -rb × f) = lambda j,   j = (n, ra × n, -n, -rb × n)
 *   dF/dV = -damping j j^T
 *   dF/dX = j g^T + c K,   g = (-h, pa, h, -pb),   c = lambda / |d|
 *   h = damping/|d| u + (stiffness - damping/|d| n·u - c) n
 *   p = h × r + damping (n·r w - w·r n)
 *
 * and c K is what a ball joint of stiffness c that pulls with f would have: [u][v] = v u^T - u·v I, and the two blocks
 * of turn and torque of one body are r q^T - r·q I with q = c r ± f.
 */
#include "hand.h"

void hand_distance(const forcec_rigid_f64 *a, const forcec_rigid_f64 *b,
                   const distance_params_f64 *params, distance_out_f64 *out)
{
    const double ks = params->stiffness, kd = params->damping;
    const vec ra = rotate(a->orientation, load(params->arm_a));
    const vec rb = rotate(b->orientation, load(params->arm_b));
    const vec wa = load(a->angular_velocity), wb = load(b->angular_velocity);
    const vec d = sub(sub(load(b->position), load(a->position)), sub(ra, rb));
    const vec u = sub(sub(load(b->velocity), load(a->velocity)), sub(cross(wa, ra), cross(wb, rb)));
    const double length = sqrt(dot(d, d)), inverse = 1.0 / length;
    const vec n = scale(inverse, d);
    const double rate = dot(n, u);
    const double lambda = ks * (length - params->rest_length) + kd * rate;
    const vec f = scale(lambda, n);
    const vec ma = cross(ra, n), mb = cross(n, rb);
    const double j[12] = { n.x, n.y, n.z, ma.x, ma.y, ma.z, -n.x, -n.y, -n.z, mb.x, mb.y, mb.z };
    row12(out->force, f.x, f.y, f.z, lambda * ma.x, lambda * ma.y, lambda * ma.z,
          -f.x, -f.y, -f.z, lambda * mb.x, lambda * mb.y, lambda * mb.z);

    /* dF/dX */
    const double c = lambda * inverse, k = kd * inverse;
    const vec h = add(scale(k, u), scale(ks - k * rate - c, n));
    const vec e = scale(kd, n);
    const vec pa = add(cross(h, ra), sub(scale(dot(e, ra), wa), scale(dot(wa, ra), e)));
    const vec pb = add(cross(h, rb), sub(scale(dot(e, rb), wb), scale(dot(wb, rb), e)));
    const vec ca = scale(c, ra), cb = scale(c, rb);
    const vec qa = add(ca, f);
    const double ta_xx = ra.x * qa.x, ta_yy = ra.y * qa.y, ta_zz = ra.z * qa.z;
    const double sa_xx = -(ta_yy + ta_zz), sa_xy = ra.x * qa.y, sa_xz = ra.x * qa.z;
    const double sa_yx = ra.y * qa.x, sa_yy = -(ta_xx + ta_zz), sa_yz = ra.y * qa.z;
    const double sa_zx = ra.z * qa.x, sa_zy = ra.z * qa.y, sa_zz = -(ta_xx + ta_yy);
    const vec qb = sub(cb, f);
    const double tb_xx = rb.x * qb.x, tb_yy = rb.y * qb.y, tb_zz = rb.z * qb.z;
    const double sb_xx = -(tb_yy + tb_zz), sb_xy = rb.x * qb.y, sb_xz = rb.x * qb.z;
    const double sb_yx = rb.y * qb.x, sb_yy = -(tb_xx + tb_zz), sb_yz = rb.y * qb.z;
    const double sb_zx = rb.z * qb.x, sb_zy = rb.z * qb.y, sb_zz = -(tb_xx + tb_yy);
    /* x = c [ra][rb] */
    const double t_xx = cb.x * ra.x, t_yy = cb.y * ra.y, t_zz = cb.z * ra.z;
    const double x_xx = -(t_yy + t_zz), x_xy = cb.x * ra.y, x_xz = cb.x * ra.z;
    const double x_yx = cb.y * ra.x, x_yy = -(t_xx + t_zz), x_yz = cb.y * ra.z;
    const double x_zx = cb.z * ra.x, x_zy = cb.z * ra.y, x_zz = -(t_xx + t_yy);
    row12(out->dfdx[0], -(n.x * h.x + c), -n.x * h.y, -n.x * h.z, n.x * pa.x, n.x * pa.y - ca.z,
          n.x * pa.z + ca.y, n.x * h.x + c, n.x * h.y, n.x * h.z, -n.x * pb.x, cb.z - n.x *
          pb.y, -(n.x * pb.z + cb.y));
    row12(out->dfdx[1], -n.y * h.x, -(n.y * h.y + c), -n.y * h.z, n.y * pa.x + ca.z, n.y * pa.y,
          n.y * pa.z - ca.x, n.y * h.x, n.y * h.y + c, n.y * h.z, -(n.y * pb.x + cb.z), -n.y *
          pb.y, cb.x - n.y * pb.z);
    row12(out->dfdx[2], -n.z * h.x, -n.z * h.y, -(n.z * h.z + c), n.z * pa.x - ca.y, n.z * pa.y
          + ca.x, n.z * pa.z, n.z * h.x, n.z * h.y, n.z * h.z + c, cb.y - n.z * pb.x, -(n.z *
          pb.y + cb.x), -n.z * pb.z);
    row12(out->dfdx[3], -ma.x * h.x, ca.z - ma.x * h.y, -(ma.x * h.z + ca.y), ma.x * pa.x +
          sa_xx, ma.x * pa.y + sa_xy, ma.x * pa.z + sa_xz, ma.x * h.x, ma.x * h.y - ca.z, ma.x *
          h.z + ca.y, -(ma.x * pb.x + x_xx), -(ma.x * pb.y + x_xy), -(ma.x * pb.z + x_xz));
    row12(out->dfdx[4], -(ma.y * h.x + ca.z), -ma.y * h.y, ca.x - ma.y * h.z, ma.y * pa.x +
          sa_yx, ma.y * pa.y + sa_yy, ma.y * pa.z + sa_yz, ma.y * h.x + ca.z, ma.y * h.y, ma.y *
          h.z - ca.x, -(ma.y * pb.x + x_yx), -(ma.y * pb.y + x_yy), -(ma.y * pb.z + x_yz));
    row12(out->dfdx[5], ca.y - ma.z * h.x, -(ma.z * h.y + ca.x), -ma.z * h.z, ma.z * pa.x +
          sa_zx, ma.z * pa.y + sa_zy, ma.z * pa.z + sa_zz, ma.z * h.x - ca.y, ma.z * h.y + ca.x,
          ma.z * h.z, -(ma.z * pb.x + x_zx), -(ma.z * pb.y + x_zy), -(ma.z * pb.z + x_zz));
    row12(out->dfdx[9], -mb.x * h.x, -(mb.x * h.y + cb.z), cb.y - mb.x * h.z, mb.x * pa.x -
          x_xx, mb.x * pa.y - x_yx, mb.x * pa.z - x_zx, mb.x * h.x, mb.x * h.y + cb.z, mb.x *
          h.z - cb.y, sb_xx - mb.x * pb.x, sb_xy - mb.x * pb.y, sb_xz - mb.x * pb.z);
    row12(out->dfdx[10], cb.z - mb.y * h.x, -mb.y * h.y, -(mb.y * h.z + cb.x), mb.y * pa.x -
          x_xy, mb.y * pa.y - x_yy, mb.y * pa.z - x_zy, mb.y * h.x - cb.z, mb.y * h.y, mb.y *
          h.z + cb.x, sb_yx - mb.y * pb.x, sb_yy - mb.y * pb.y, sb_yz - mb.y * pb.z);
    row12(out->dfdx[11], -(mb.z * h.x + cb.y), cb.x - mb.z * h.y, -mb.z * h.z, mb.z * pa.x -
          x_xz, mb.z * pa.y - x_yz, mb.z * pa.z - x_zz, mb.z * h.x + cb.y, mb.z * h.y - cb.x,
          mb.z * h.z, sb_zx - mb.z * pb.x, sb_zy - mb.z * pb.y, sb_zz - mb.z * pb.z);

    /* dF/dV: whole rows at once. The loops must stay loops for gcc to make vectors of them. */
#pragma GCC unroll 1
    for (int row = 0; row < 12; row++) {
        const double kj = -kd * j[row];
#pragma GCC unroll 1
        for (int column = 0; column < 12; column++)
            out->dfdv[row][column] = kj * j[column];
    }
    /* The other body's force. */
#pragma GCC unroll 1
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 12; column++)
            out->dfdx[6 + row][column] = -out->dfdx[row][column];
}
