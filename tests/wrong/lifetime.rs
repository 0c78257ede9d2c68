fn first<'a>(v: &'a Vec3) -> Real {
    v.x
}
