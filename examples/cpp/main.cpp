#include <cstdio>
#include "bands.h"

int main()
{
    const double mass = 1.0, gravity = 9.81, step = 0.1;
    const forcec_particle_f64 nail = {};
    forcec_particle_f64 weight = {};
    weight.position[2] = -1.0;
    const rubber_band_params_f64 params = { 1.0, 70.2 };
    rubber_band_out_f64 out = {};

    // Implicit Euler along z: (m − h² ∂F/∂X) Δv = h (F − m g + h ∂F/∂X v).
    for (int i = 0; i < 2000; i++) {
        rubber_band_f64(&nail, &weight, &params, &out);
        const double stiffness = out.dfdx[5][5];
        const double force = out.force[5] - mass * gravity;
        const double change = step * (force + step * stiffness * weight.velocity[2])
            / (mass - step * step * stiffness);
        weight.velocity[2] += change;
        weight.position[2] += step * weight.velocity[2];
    }
    rubber_band_f64(&nail, &weight, &params, &out);
    std::printf("hangs %.3f m below, force %.3f N\n", -weight.position[2], -out.force[5]);
}
