async fn one(x: Real) -> Real {
    x
}

unsafe fn two(x: Real) -> Real {
    x
}

extern "C" fn three(x: Real) -> Real {
    x
}
