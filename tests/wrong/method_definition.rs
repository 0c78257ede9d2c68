impl Spring {
    fn energy(&self) -> Real {
        self.k
    }
}
