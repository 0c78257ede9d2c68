//! Single states and single functions in high precision, for tests of generated code.
//!
//! In: a force function and its program, or a function of the table. Out: states from the generator of
//! `check`, and the exact values at these states, rounded once to doubles. A probe returns numbers;
//! [`crate::verify::check`] returns verdicts.

use crate::derive::partials::partial;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Precision};
use crate::math::random::Random;
use crate::model::bodies::{Domain, Parameter, ParameterType, Signature, Slot};
use crate::model::outputs::Part;
use crate::sample::inputs::{Inputs, Places};
use crate::sample::states::{Family, State, draw, seed};
use crate::scalar::{Id, eval};
use crate::vector::Graph;
use crate::vector::definition::Definition;
use crate::verify::Subject;
use crate::verify::big::Big;
use crate::verify::dual::Scalar;
use crate::verify::input_errors;
use crate::verify::oracle::{Oracle, Point, Singular};
use crate::verify::source::Source;
use crate::verify::tape::Tape;
use crate::verify::written::Written;

/// The exact outputs at one state.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Every output row by row, in the memory order of a kernel's `out`.
    pub outputs: Vec<f64>,
    /// Whether some entry of the force is nonzero.
    pub pushes: bool,
}

/// Evaluates one kernel at single states. Inputs are flat: the arguments in order, each in memory order.
pub struct Probe<'a> {
    subject: &'a Subject<'a>,
    places: Places,
    tape: Tape,
}

impl<'a> Probe<'a> {
    /// Prepares a kernel.
    pub fn new(subject: &'a Subject<'a>) -> Probe<'a> {
        let places = Places::new(&subject.program.signature);
        let outputs: Vec<Id> = subject.program.outputs().collect();
        let tape = Tape::new(subject.program, &places, &outputs);
        Probe { subject, places, tape }
    }

    /// The inputs of one state of a family; determined by seed and index on every platform.
    pub fn draw(&self, family: Family, seed_from: u64, index: usize) -> Vec<f64> {
        let mut random = Random::new(seed(seed_from, family, index as u64));
        let gains = Oracle::new(self.subject.source, &self.places).is_constraint();
        draw(&self.places, gains, family, index, &mut random).values
    }

    /// The approximate cost of [`Probe::truth`] at a state, in 320-bit additions; ten million take a second.
    pub fn cost(&self) -> u64 {
        Oracle::new(self.subject.source, &self.places).cost()
    }

    /// The program's outputs from the source, by difference quotients in 320 bits; `None` if one does not
    /// exist.
    pub fn truth(&self, inputs: &[f64]) -> Option<Truth> {
        let oracle = Oracle::new(self.subject.source, &self.places);
        let truth = |point: Point| -> Result<Truth, Singular> {
            let pushes = point.pushes();
            let mut outputs: Vec<f64> = Vec::new();
            for array in &self.subject.program.arrays {
                let derivative = array.part.row().columns.is_some();
                let noise = if derivative { point.noise } else { 0.0 };
                outputs.extend(point.part(array.part)?.iter().map(|x| flushed(x, noise)));
            }
            Ok(Truth { outputs, pushes })
        };
        oracle.point(&State { values: inputs.to_vec(), scale: 1.0 }).and_then(truth).ok()
    }

    /// The program's outputs, evaluated in 320 bits.
    pub fn program(&self, inputs: &[f64]) -> Vec<f64> {
        let input = |slot| Big::from_f64(inputs[self.places.place(slot)]);
        eval::evaluate(self.subject.program, &input).iter().map(Big::to_f64).collect()
    }

    /// The program's outputs, computed from the source with dual numbers, in a precision or in 320 bits.
    pub fn text(&self, precision: Option<Precision>, inputs: &[f64]) -> Vec<f64> {
        match precision {
            Some(Precision::F64) => self.written::<f64>(inputs),
            Some(Precision::F32) => self.written::<f32>(inputs),
            None => self.written::<Big>(inputs),
        }
    }

    fn written<F: Scalar>(&self, inputs: &[f64]) -> Vec<f64> {
        let written: Written<F> = Written::new(self.subject.source, &self.places);
        let text = written.at(inputs.iter().map(|x| F::of(*x)).collect(), true);
        let arrays = self.subject.program.arrays.iter();
        arrays.flat_map(|array| text.part(array.part)).map(|x| x.wide()).collect()
    }

    /// The input that an argument's entry reads.
    pub fn input(&self, inputs: &[f64], slot: Slot) -> f64 {
        inputs[self.places.place(slot)]
    }

    /// Bounds on the output errors from rounding to doubles and from quaternions not quite of length one.
    pub fn bounds(&self, inputs: &[f64]) -> Vec<f64> {
        let errors = input_errors(&self.places, inputs);
        self.tape.bounds(inputs, &errors).iter().map(|bounded| bounded.error).collect()
    }

    /// The inputs with their names.
    pub fn inputs(&self, inputs: &[f64]) -> Inputs {
        self.places.inputs(inputs)
    }

    /// An output's array and its entry's name, such as `dfdx[a.ry][b.x]`.
    pub fn name(&self, output: usize) -> (Part, String) {
        let mut outputs = self.subject.program.arrays.iter().flat_map(|array| array.outputs());
        let (output, _) = outputs.nth(output).expect("an output of the program");
        (output.part, output.named(&self.places.signature))
    }
}

/// The nearest double, or zero if the entry is below the noise of the difference quotients.
fn flushed(x: &Big, noise: f64) -> f64 {
    let x = x.to_f64();
    if x.abs() <= noise { 0.0 } else { x }
}

/// The relative distance of two definitions' rows, energy or force at the same inputs, in 320 bits; `None` if
/// a value or derivative does not exist.
pub fn apart(left: &Definition, right: &Definition, inputs: &[f64]) -> Option<f64> {
    let rows = |definition: &Definition| {
        let places = Places::new(&definition.graph.signature);
        let oracle = Oracle::new(definition, &places);
        let point = oracle.point(&State { values: inputs.to_vec(), scale: 1.0 }).ok()?;
        Some(point.rows.clone())
    };
    let (left, right) = (rows(left)?, rows(right)?);
    let pairs = left.into_iter().zip(right);
    Some(pairs.map(|(x, y)| distance(x, y)).fold(0.0, f64::max))
}

/// |x − y|/max(|x|, |y|)
fn distance(x: Big, y: Big) -> f64 {
    let size = x.to_f64().abs().max(y.to_f64().abs());
    let difference = (x - y).to_f64().abs();
    if difference == 0.0 { 0.0 } else { difference / size }
}

/// A function's value in 320 bits, rounded to a double.
pub fn value(function: Function, arguments: &[f64]) -> f64 {
    let arguments: Vec<Big> = arguments.iter().map(|x| Big::from_f64(*x)).collect();
    Big::call(function, &arguments).to_f64()
}

/// A partial derivative by its formula and by central differences, both in 320 bits.
#[derive(Clone, Copy, Debug)]
pub struct Partial {
    /// The derivative by formula.
    pub formula: f64,
    /// The derivative by differences.
    pub difference: f64,
    /// The relative distance of both before rounding.
    pub apart: f64,
}

/// The partial derivatives of a function at a point of its open domain.
pub fn partials(function: Function, arguments: &[f64]) -> Vec<Partial> {
    const STEP: i32 = 100;
    let row = function.row();
    let parameter =
        |k| Parameter { name: format!("x{k}"), ty: ParameterType::Real, domain: Domain::Any, value: None };
    let signature = Signature { parameters: (0..row.arity).map(parameter).collect(), ..Signature::default() };
    let places = Places::new(&signature);
    let mut graph = Graph::new(signature.clone());
    let x: Vec<_> = (0..row.arity).map(|k| graph.entry(signature.parameter_slot(k, 0))).collect();
    let result = graph.call(function, &x);
    let formulas: Vec<usize> =
        (0..row.arity).map(|k| partial(&mut graph, function, &x, result, k).index()).collect();
    let source: Source<Big> = Source::new(&graph, &places, formulas.iter().copied());
    let point: Vec<Big> = arguments.iter().map(|x| Big::from_f64(*x)).collect();
    let values = source.evaluate(&point);
    let moved = |k: usize, sign: i32| {
        let mut moved = point.clone();
        moved[k] = moved[k].clone() + Big::integer(sign).scaled(-STEP);
        Big::call(function, &moved)
    };
    let partial = |(k, node): (usize, &usize)| {
        let formula = source.get(&values, *node).real().clone();
        let difference = (moved(k, 1) - moved(k, -1)).scaled(STEP - 1);
        Partial {
            formula: formula.to_f64(),
            difference: difference.to_f64(),
            apart: distance(formula, difference),
        }
    };
    formulas.iter().enumerate().map(partial).collect()
}

/// The flat value of a force function at one state: the rows of C, the energy, or the force on each body;
/// `None` if the value or a derivative does not exist.
pub fn returned(definition: &Definition, inputs: &[f64]) -> Option<Vec<f64>> {
    let places = Places::new(&definition.graph.signature);
    let oracle = Oracle::new(definition, &places);
    let point = oracle.point(&State { values: inputs.to_vec(), scale: 1.0 }).ok()?;
    Some(point.rows.iter().map(Big::to_f64).collect())
}
