/*
 * Ball joint by hand: with r the arms in the world, f = stiffness d + damping u pulls at the anchors.
 *
 *   F = (f, ra × f, -f, -rb × f)
 *   N(r, w) = stiffness [r] + damping (r w^T - w·r I) = ±df/dtheta
 *   [r] N(r, w) = stiffness [r][r] - damping w·r [r]
 *   [u][v] = v u^T - u·v I
 *
 * The two blocks of turn and torque of one body are r g^T - r·g I - s [r] with g = stiffness r ± f, s = damping w·r.
 */
#include "hand.h"

void hand_point_to_point(const forcec_rigid_f64 *a, const forcec_rigid_f64 *b,
                         const point_to_point_params_f64 *params, point_to_point_out_f64 *out)
{
    const double ks = params->stiffness, kd = params->damping;
    const vec ra = rotate(a->orientation, load(params->arm_a));
    const vec rb = rotate(b->orientation, load(params->arm_b));
    const vec wa = load(a->angular_velocity), wb = load(b->angular_velocity);
    const vec d = sub(sub(load(b->position), load(a->position)), sub(ra, rb));
    const vec u = sub(sub(load(b->velocity), load(a->velocity)), sub(cross(wa, ra), cross(wb, rb)));
    const vec f = add(scale(ks, d), scale(kd, u));
    const vec ta = cross(ra, f), tb = cross(f, rb);
    row12(out->force, f.x, f.y, f.z, ta.x, ta.y, ta.z, -f.x, -f.y, -f.z, tb.x, tb.y, tb.z);

    /* dF/dX */
    const vec ka = scale(ks, ra), kb = scale(ks, rb);
    const vec ea = scale(kd, wa), eb = scale(kd, wb);
    /* na = N(ra, wa) */
    const double pa_xx = ra.x * ea.x, pa_yy = ra.y * ea.y, pa_zz = ra.z * ea.z;
    const double na_xx = -(pa_yy + pa_zz), na_xy = ra.x * ea.y - ka.z, na_xz = ra.x * ea.z + ka.y;
    const double na_yx = ra.y * ea.x + ka.z, na_yy = -(pa_xx + pa_zz), na_yz = ra.y * ea.z - ka.x;
    const double na_zx = ra.z * ea.x - ka.y, na_zy = ra.z * ea.y + ka.x, na_zz = -(pa_xx + pa_yy);
    /* nb = N(rb, wb) */
    const double pb_xx = rb.x * eb.x, pb_yy = rb.y * eb.y, pb_zz = rb.z * eb.z;
    const double nb_xx = -(pb_yy + pb_zz), nb_xy = rb.x * eb.y - kb.z, nb_xz = rb.x * eb.z + kb.y;
    const double nb_yx = rb.y * eb.x + kb.z, nb_yy = -(pb_xx + pb_zz), nb_yz = rb.y * eb.z - kb.x;
    const double nb_zx = rb.z * eb.x - kb.y, nb_zy = rb.z * eb.y + kb.x, nb_zz = -(pb_xx + pb_yy);
    /* sa = r g^T - r·g I - s [r] */
    const vec ga = add(ka, f);
    const vec za = scale(pa_xx + pa_yy + pa_zz, ra);
    const double ga_xx = ra.x * ga.x, ga_yy = ra.y * ga.y, ga_zz = ra.z * ga.z;
    const double sa_xx = -(ga_yy + ga_zz), sa_xy = ra.x * ga.y + za.z, sa_xz = ra.x * ga.z - za.y;
    const double sa_yx = ra.y * ga.x - za.z, sa_yy = -(ga_xx + ga_zz), sa_yz = ra.y * ga.z + za.x;
    const double sa_zx = ra.z * ga.x + za.y, sa_zy = ra.z * ga.y - za.x, sa_zz = -(ga_xx + ga_yy);
    /* sb = r g^T - r·g I - s [r] */
    const vec gb = sub(kb, f);
    const vec zb = scale(pb_xx + pb_yy + pb_zz, rb);
    const double gb_xx = rb.x * gb.x, gb_yy = rb.y * gb.y, gb_zz = rb.z * gb.z;
    const double sb_xx = -(gb_yy + gb_zz), sb_xy = rb.x * gb.y + zb.z, sb_xz = rb.x * gb.z - zb.y;
    const double sb_yx = rb.y * gb.x - zb.z, sb_yy = -(gb_xx + gb_zz), sb_yz = rb.y * gb.z + zb.x;
    const double sb_zx = rb.z * gb.x + zb.y, sb_zy = rb.z * gb.y - zb.x, sb_zz = -(gb_xx + gb_yy);
    /* xab = -[ra] nb */
    const double xab_xx = ra.z * nb_yx - ra.y * nb_zx;
    const double xab_xy = ra.z * nb_yy - ra.y * nb_zy;
    const double xab_xz = ra.z * nb_yz - ra.y * nb_zz;
    const double xab_yx = ra.x * nb_zx - ra.z * nb_xx;
    const double xab_yy = ra.x * nb_zy - ra.z * nb_xy;
    const double xab_yz = ra.x * nb_zz - ra.z * nb_xz;
    const double xab_zx = ra.y * nb_xx - ra.x * nb_yx;
    const double xab_zy = ra.y * nb_xy - ra.x * nb_yy;
    const double xab_zz = ra.y * nb_xz - ra.x * nb_yz;
    /* xba = -[rb] na */
    const double xba_xx = rb.z * na_yx - rb.y * na_zx;
    const double xba_xy = rb.z * na_yy - rb.y * na_zy;
    const double xba_xz = rb.z * na_yz - rb.y * na_zz;
    const double xba_yx = rb.x * na_zx - rb.z * na_xx;
    const double xba_yy = rb.x * na_zy - rb.z * na_xy;
    const double xba_yz = rb.x * na_zz - rb.z * na_xz;
    const double xba_zx = rb.y * na_xx - rb.x * na_yx;
    const double xba_zy = rb.y * na_xy - rb.x * na_yy;
    const double xba_zz = rb.y * na_xz - rb.x * na_yz;
    row12(out->dfdx[0], -ks, 0.0, 0.0, na_xx, na_xy, na_xz, ks, 0.0, 0.0, -nb_xx, -nb_xy, -nb_xz);
    row12(out->dfdx[1], 0.0, -ks, 0.0, na_yx, na_yy, na_yz, 0.0, ks, 0.0, -nb_yx, -nb_yy, -nb_yz);
    row12(out->dfdx[2], 0.0, 0.0, -ks, na_zx, na_zy, na_zz, 0.0, 0.0, ks, -nb_zx, -nb_zy, -nb_zz);
    row12(out->dfdx[3], 0.0, ka.z, -ka.y, sa_xx, sa_xy, sa_xz, 0.0, -ka.z, ka.y, xab_xx, xab_xy,
          xab_xz);
    row12(out->dfdx[4], -ka.z, 0.0, ka.x, sa_yx, sa_yy, sa_yz, ka.z, 0.0, -ka.x, xab_yx, xab_yy,
          xab_yz);
    row12(out->dfdx[5], ka.y, -ka.x, 0.0, sa_zx, sa_zy, sa_zz, -ka.y, ka.x, 0.0, xab_zx, xab_zy,
          xab_zz);
    row12(out->dfdx[9], 0.0, -kb.z, kb.y, xba_xx, xba_xy, xba_xz, 0.0, kb.z, -kb.y, sb_xx,
          sb_xy, sb_xz);
    row12(out->dfdx[10], kb.z, 0.0, -kb.x, xba_yx, xba_yy, xba_yz, -kb.z, 0.0, kb.x, sb_yx,
          sb_yy, sb_yz);
    row12(out->dfdx[11], -kb.y, kb.x, 0.0, xba_zx, xba_zy, xba_zz, kb.y, -kb.x, 0.0, sb_zx,
          sb_zy, sb_zz);

    /* dF/dV */
    const vec da = scale(kd, ra), db = scale(kd, rb);
    const double qa_xx = da.x * ra.x, qa_yy = da.y * ra.y, qa_zz = da.z * ra.z;
    const double ma_xx = -(qa_yy + qa_zz), ma_yy = -(qa_xx + qa_zz), ma_zz = -(qa_xx + qa_yy);
    const double ma_xy = da.x * ra.y, ma_xz = da.x * ra.z, ma_yz = da.y * ra.z;
    const double qb_xx = db.x * rb.x, qb_yy = db.y * rb.y, qb_zz = db.z * rb.z;
    const double mb_xx = -(qb_yy + qb_zz), mb_yy = -(qb_xx + qb_zz), mb_zz = -(qb_xx + qb_yy);
    const double mb_xy = db.x * rb.y, mb_xz = db.x * rb.z, mb_yz = db.y * rb.z;
    /* c = damping [ra][rb] */
    const double q_xx = db.x * ra.x, q_yy = db.y * ra.y, q_zz = db.z * ra.z;
    const double c_xx = -(q_yy + q_zz), c_xy = db.x * ra.y, c_xz = db.x * ra.z;
    const double c_yx = db.y * ra.x, c_yy = -(q_xx + q_zz), c_yz = db.y * ra.z;
    const double c_zx = db.z * ra.x, c_zy = db.z * ra.y, c_zz = -(q_xx + q_yy);
    row12(out->dfdv[0], -kd, 0.0, 0.0, 0.0, -da.z, da.y, kd, 0.0, 0.0, 0.0, db.z, -db.y);
    row12(out->dfdv[1], 0.0, -kd, 0.0, da.z, 0.0, -da.x, 0.0, kd, 0.0, -db.z, 0.0, db.x);
    row12(out->dfdv[2], 0.0, 0.0, -kd, -da.y, da.x, 0.0, 0.0, 0.0, kd, db.y, -db.x, 0.0);
    row12(out->dfdv[3], 0.0, da.z, -da.y, ma_xx, ma_xy, ma_xz, 0.0, -da.z, da.y, -c_xx, -c_xy,
          -c_xz);
    row12(out->dfdv[4], -da.z, 0.0, da.x, ma_xy, ma_yy, ma_yz, da.z, 0.0, -da.x, -c_yx, -c_yy,
          -c_yz);
    row12(out->dfdv[5], da.y, -da.x, 0.0, ma_xz, ma_yz, ma_zz, -da.y, da.x, 0.0, -c_zx, -c_zy,
          -c_zz);
    row12(out->dfdv[9], 0.0, -db.z, db.y, -c_xx, -c_yx, -c_zx, 0.0, db.z, -db.y, mb_xx, mb_xy,
          mb_xz);
    row12(out->dfdv[10], db.z, 0.0, -db.x, -c_xy, -c_yy, -c_zy, -db.z, 0.0, db.x, mb_xy, mb_yy,
          mb_yz);
    row12(out->dfdv[11], -db.y, db.x, 0.0, -c_xz, -c_yz, -c_zz, db.y, -db.x, 0.0, mb_xz, mb_yz,
          mb_zz);

    /* The other body's force, in vectors: the loop must stay a loop. */
#pragma GCC unroll 1
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 12; column++) {
            out->dfdx[6 + row][column] = -out->dfdx[row][column];
            out->dfdv[6 + row][column] = -out->dfdv[row][column];
        }
}
