fn area(a: Vec3, b: Vec3) -> Real {
    0.5 * a.cros(&b).norm()
}
