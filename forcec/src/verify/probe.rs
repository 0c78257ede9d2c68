//! Single states and single functions in high precision, for tests of what was emitted.
//!
//! In: a force function and its program, or a row of the function table. Out: states from the check's own generator, and
//! what the mathematics gives there, rounded once to doubles. A check is [`crate::verify::check`]; a probe judges nothing.

use crate::derive::partials::partial;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Precision};
use crate::model::bodies::{Domain, Parameter, ParameterType, Signature, Slot};
use crate::model::outputs::Part;
use crate::sample::inputs::{Inputs, Places};
use crate::sample::states::{Family, Random, State, draw, seed};
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

/// What the source says at one state.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Every result row by row: the order of a kernel's `out` in memory.
    pub outputs: Vec<f64>,
    /// Whether some row pushes; what is no one-sided constraint always does.
    pub pushes: bool,
}

/// One kernel, ready to be asked about single states. Inputs are flat: the arguments in order, each in memory order.
pub struct Probe<'a> {
    subject: &'a Subject<'a>,
    places: Places,
    tape: Tape,
}

impl<'a> Probe<'a> {
    /// Asks about this kernel.
    pub fn new(subject: &'a Subject<'a>) -> Probe<'a> {
        let places = Places::new(&subject.program.signature);
        let outputs: Vec<Id> = subject.program.outputs().collect();
        let tape = Tape::new(subject.program, &places, &outputs);
        Probe { subject, places, tape }
    }

    /// The inputs of one state of a family; the same for the same seed and index on every machine.
    pub fn draw(&self, family: Family, seed_from: u64, index: usize) -> Vec<f64> {
        let mut random = Random::new(seed(seed_from, family, index as u64));
        let gains = Oracle::new(self.subject.source, &self.places).is_constraint();
        draw(&self.places, gains, family, index, &mut random).values
    }

    /// About what [`Probe::truth`] costs at one state, in additions of 320 bits: ten million take about a second.
    pub fn cost(&self) -> u64 {
        Oracle::new(self.subject.source, &self.places).cost()
    }

    /// What the program computes, from the source by differences in 320 bits; `None` where some of it does not exist.
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

    /// What the program computes when it computes in 320 bits.
    pub fn program(&self, inputs: &[f64]) -> Vec<f64> {
        let input = |slot| Big::from_f64(inputs[self.places.place(slot)]);
        eval::evaluate(self.subject.program, &input).iter().map(Big::to_f64).collect()
    }

    /// What the program computes, from the source as written with dual numbers, in a precision or in 320 bits.
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

    /// The entry of an argument among the inputs.
    pub fn input(&self, inputs: &[f64], slot: Slot) -> f64 {
        inputs[self.places.place(slot)]
    }

    /// How far rounding in doubles, and the bits of a quaternion from length one, may take each output.
    pub fn bounds(&self, inputs: &[f64]) -> Vec<f64> {
        let errors = input_errors(&self.places, inputs);
        self.tape.bounds(inputs, &errors).iter().map(|bounded| bounded.error).collect()
    }

    /// The inputs with their names.
    pub fn inputs(&self, inputs: &[f64]) -> Inputs {
        self.places.inputs(inputs)
    }

    /// An output's array and its name: `dfdx[a.ry][b.x]`.
    pub fn name(&self, output: usize) -> (Part, String) {
        let mut outputs = self.subject.program.arrays.iter().flat_map(|array| array.outputs());
        let (output, _) = outputs.nth(output).expect("an output of the program");
        (output.part, output.named(&self.places.signature))
    }
}

/// The double nearest to an entry, zero where only the noise of differences is left of it.
fn flushed(x: &Big, noise: f64) -> f64 {
    let x = x.to_f64();
    if x.abs() <= noise { 0.0 } else { x }
}

/// How far the rows, the energy or the force of two definitions are apart in 320 bits at the same inputs, relative to the
/// larger; `None` where one of them or a derivative does not exist.
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

/// |x − y| relative to the larger.
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

/// A function's partial derivative by its formula and by central differences of its value, both in 320 bits.
#[derive(Clone, Copy, Debug)]
pub struct Partial {
    /// By the formula of its row.
    pub formula: f64,
    /// By differences.
    pub difference: f64,
    /// How far apart they are before they are rounded, relative to the larger.
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

/// What a force function returns at one state, flat: the rows of C, the energy, or the force on each body; `None` where it
/// or a derivative does not exist.
pub fn returned(definition: &Definition, inputs: &[f64]) -> Option<Vec<f64>> {
    let places = Places::new(&definition.graph.signature);
    let oracle = Oracle::new(definition, &places);
    let point = oracle.point(&State { values: inputs.to_vec(), scale: 1.0 }).ok()?;
    Some(point.rows.iter().map(Big::to_f64).collect())
}
