#include <stdio.h>
#include "bands.h"

static void print(const char *name, const double *x)
{
    printf("%-12s%6.1f %6.1f %6.1f\n", name, x[0], x[1], x[2]);
}

int main(void)
{
    forcec_particle_f64 p0 = { .position = { 0, 0, 0 } };
    forcec_particle_f64 p1 = { .position = { 1, 2, 2 } };
    rubber_band_params_f64 params = { .rest_length = 1, .stiffness = 10 };
    rubber_band_out_f64 out;

    rubber_band_f64(&p0, &p1, &params, &out);
    print("F on p1", out.force + 3);
    print("F on p0", out.force);
    print("dF/dX on p1", out.dfdx[3] + 3);
    return 0;
}
