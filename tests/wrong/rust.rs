//! Rust outside the force language.

// case: closure
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let square = |x: Real| x * x;
//~              ^ a function without a name
//~ ERROR closures are not part of the force language
//~ HELP write a helper `fn` beside the function and call it
    k * a.position.dot(&b.position)
}

// case: generic_function
#[energy]
pub fn well<T: Scalar>(a: Particle, k: T) -> Real
//~        ^^^^^^^^^^^ every type has to be known
//~ ERROR generics are not part of the force language
//~ HELP write the types out, once for each use
where
//~ 1-5 every type is known here
//~ ERROR `where` clauses are not part of the force language
//~ HELP leave it out
    T: Copy,
{
    k * a.position.x
}

// case: lifetime
fn first<'a>(v: &'a Vec3) -> Real {
//~     ^^^^ values are copied, nothing is borrowed
//~ ERROR lifetimes are not part of the force language
//~ HELP leave it out
//~              ^^ values are copied, nothing is borrowed
//~ ERROR lifetimes are not part of the force language
//~ HELP leave it out
    v.x
}

// case: turbofish
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * a.position.dot::<Real>(&b.position)
//~                     ^^^^^^ every type is known here
//~ ERROR generic arguments are not part of the force language
//~ HELP leave out `::<…>`
}

// case: mutable_reference
fn shift(x: &mut Real) {
//~         ^^^^ nothing is changed through a reference
//~ ERROR mutable references are not part of the force language
//~ HELP take the value and return the new one
    *x += 1.0;
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    shift(&mut k);
//~       ^^^^ nothing is changed through a reference
//~ ERROR mutable references are not part of the force language
//~ HELP pass the value, and assign what the helper returns
    k * a.position.dot(&b.position)
}

// case: if_let
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if let d = k { d * a.position.dot(&b.position) } else { 0.0 }
//~    ^^^ patterns always match here
//~ ERROR `let` conditions are not part of the force language
//~ HELP compare with `<`, `<=` or `==`
}

// case: match_expression
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    match k {
//~ ^^^^^ there are no cases to match
//~ ERROR `match` expressions are not part of the force language
//~ HELP write `if … { … } else if … { … } else { … }`
        _ => a.position.dot(&b.position),
    }
}

// case: struct_pattern
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let Vec3 { x, y, z } = a.position - b.position;
//~     ^^^^^^^^^^^^^^^^ neither a name nor a tuple of names
//~ ERROR such patterns are not part of the force language
//~ HELP bind a name and take its fields, or write `let (p, q) = …;`
    k * (x + y + z)
}

// case: question_mark
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * a.position.dot(&b.position)?
//~                                ^ no value here is an error
//~ ERROR `?` operators are not part of the force language
//~ HELP leave it out
}

// case: return_at_the_end
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    return k * a.position.dot(&b.position);
//~ ^^^^^^ the last expression is the value anyway
//~ ERROR `return` is not part of the force language
//~ HELP write the expression without `return` and without `;`
}

// case: return_early
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if k < 0.0 {
        return 0.0;
//~     ^^^^^^ every branch runs to its end
//~ ERROR early returns are not part of the force language
//~ HELP write `if … { … } else { … }`, whose value is its last expression
    }
    k * a.position.dot(&b.position)
}

// case: macro_call
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    println!("{}", k);
//~ ^^^^^^^ the compiler does not expand it
//~ ERROR macros are not part of the force language
//~ HELP write out what it stands for; nothing can be printed or asserted in a kernel
    k * a.position.dot(&b.position)
}

// case: string
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let s = "k";
//~         ^^^ a string or character literal
//~ ERROR text is not a value in the force language
    k * a.position.dot(&b.position)
}

// case: nested_function
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    fn square(x: Real) -> Real { x * x }
//~    ^^^^^^ not part of the force language
//~ ERROR a function within a function
//~ HELP write the helper beside the function
    k * square(a.position.dot(&b.position))
}

// case: method_definition
impl Spring {
//~ 1-4 a force file holds functions, constants and `use`
//~ ERROR `impl` blocks are not part of the force language
//~ HELP write helper functions, `fn name(value: Vec3) -> Real`
    fn energy(&self) -> Real {
        self.k
    }
}

// case: plain_module
mod springs {
//~ 1-11 a force file holds functions, constants and `use`
//~ ERROR `springs` is not a module of forces
//~ HELP write `#[forces]` above a module of force functions, or keep it in another file
    #[energy]
    pub fn well(a: Particle) -> Real {
        a.position.x
    }
}

// case: unsafe_async_extern
async fn one(x: Real) -> Real {
//~ 1-5 a force function only computes a value
//~ ERROR `async` functions are not part of the force language
//~ HELP leave `async` out
    x
}

unsafe fn two(x: Real) -> Real {
//~ 1-6 a force function only computes a value
//~ ERROR `unsafe` functions are not part of the force language
//~ HELP leave `unsafe` out
    x
}

extern "C" fn three(x: Real) -> Real {
//~ 1-6 a force function only computes a value
//~ ERROR `extern` functions are not part of the force language
//~ HELP leave `extern` out
    x
}
