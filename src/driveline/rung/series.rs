//! The shortest rung: exponential series over a span that is short for the fastest eigenvalue.

use nalgebra::ComplexField;

use crate::matrices::{O, Row, STATES, System, Systems, TORQUES};
use crate::rung::builder::{Active, Builder, RAMP_COLUMN, TORQUE_COLUMN};
use crate::rung::lanes::{Lanes, add, dot};
use crate::rung::motion::{ANGLE, MOMENT};
use crate::rung::start::{ENTRIES, MOVING, MOVING_STATES, moving, worked};

/// Most terms of the exponential series: with ‖A t‖ ≤ 0.05 the next one is 0.05^10 / 10! < 1e-19.
const SERIES_TERMS: u32 = 9;
/// Size of a term beside which all further ones are below round-off [1].
const NO_TERM: f64 = 1e-19;
/// Nodes of Gauss' rule.
const NODES: usize = 3;

impl System {
    /// The column of A that belongs to one of the numbers that move.
    pub(crate) fn column(&self, moving: usize) -> &[f64; STATES] {
        &self.a.data.0[MOVING_STATES[moving]]
    }
}

/// A term of Ψ − 1 by columns, and what it changes of the numbers that move.
struct Term {
    columns: [Lanes<STATES>; ENTRIES],
    changes: [Lanes<MOVING>; ENTRIES],
}

/// What moves at a node of Gauss' rule: the eight numbers, and the change of ω_o.
#[derive(Clone, Copy)]
struct Node {
    at: f64,
    /// Its power of the order of the last term.
    power: f64,
    weight: f64,
    moving: [Lanes<MOVING>; ENTRIES],
    omega_o: [f64; ENTRIES],
}

impl Builder {
    /// Turns what leads nowhere into a rung of a span `t` [s] by series; losses by Gauss' rule of order 6.
    ///
    /// `norm`: ‖A t‖ [1], ≤ 0.05.
    #[inline(never)] // its stack is free again when the doublings need theirs
    pub(crate) fn base(
        &mut self,
        systems: &Systems,
        set: usize,
        active: &Active,
        t: f64,
        norm: f64,
    ) {
        let system = &systems.by_stuck[set & 3];
        self.t = t;
        let mut nodes = nodes();
        let mut term = Term::first(system, systems.ratio, active, t);
        let mut size = 1.0;
        for order in (1..=SERIES_TERMS).map(f64::from) {
            self.add_term(&term, systems.synchroniser_ratio, active, order);
            nodes.iter_mut().for_each(|node| node.add(&term, active));
            size *= norm / order;
            if size < NO_TERM {
                break;
            }
            term.advance(system, systems.ratio, active, t / (order + 1.0));
        }
        for node in &nodes {
            self.add_loss(systems, set, active, node);
        }
    }

    /// Adds a term to the state, its worked speeds to angles and moments.
    fn add_term(&mut self, term: &Term, synchroniser_ratio: [f64; 2], active: &Active, order: f64) {
        let (angle, moment) = (self.t / (order + 1.0), self.t * self.t / (order + 2.0));
        for &j in active.columns() {
            let (column, term) = (&mut self.columns[j], &term.columns[j]);
            add(column, term, 1.0);
            let speeds = worked(term, synchroniser_ratio);
            for (q, speed) in speeds.into_iter().enumerate() {
                column[ANGLE + q] += angle * speed;
                column[MOMENT + q] += moment * speed;
            }
        }
    }

    /// Adds the power lost at a node of Gauss' rule.
    fn add_loss(&mut self, systems: &Systems, set: usize, active: &Active, node: &Node) {
        let weight = node.weight * self.t;
        let viscous = MOVING_STATES.map(|j| {
            let column = &systems.viscous.data.0[j];
            Lanes(MOVING_STATES.map(|i| weight * column[i]))
        });
        for (at, &j) in active.columns().iter().enumerate() {
            let mut power = Lanes::<MOVING>::ZERO;
            for (column, moving) in viscous.iter().zip(&node.moving[j].0) {
                if *moving != 0.0 {
                    add(&mut power, column, *moving);
                }
            }
            for &i in &active.columns()[..=at] {
                let loss = self.loss[j][i] + dot(&node.moving[i], &power);
                (self.loss[j][i], self.loss[i][j]) = (loss, loss);
            }
        }
        if systems.meshes_lose() {
            let torque = lost_torque(systems, set, node, node.at * self.t);
            self.add_mesh_loss(&node.omega_o, &torque, weight);
            for (sum, torque) in self.output.iter_mut().zip(torque) {
                *sum += weight * torque;
            }
        }
    }
}

impl Term {
    /// t (A B 0).
    fn first(system: &System, ratio: [f64; 2], active: &Active, t: f64) -> Self {
        let mut columns = [Lanes::ZERO; ENTRIES];
        for (j, column) in columns[..TORQUE_COLUMN].iter_mut().enumerate() {
            *column = Lanes(system.column(j).map(|entry| entry * t));
        }
        for (column, b) in columns[TORQUE_COLUMN..].iter_mut().zip(&system.b.data.0) {
            *column = Lanes(b.map(|entry| entry * t));
        }
        let mut term = Self {
            columns,
            changes: [Lanes::ZERO; ENTRIES],
        };
        term.take_changes(ratio, active);
        term
    }

    /// Becomes the next term: A times it times `factor`; a ramp follows its torque by an order.
    #[inline(never)] // its stack is free again when the losses need theirs
    fn advance(&mut self, system: &System, ratio: [f64; 2], active: &Active, factor: f64) {
        let a: [Lanes<STATES>; MOVING] = core::array::from_fn(|k| Lanes(*system.column(k)));
        for q in 0..TORQUES {
            self.columns[RAMP_COLUMN + q] =
                Lanes(self.columns[TORQUE_COLUMN + q].map(|entry| entry * factor));
        }
        for &j in active.columns().iter().filter(|j| **j < RAMP_COLUMN) {
            let mut next = Lanes::ZERO;
            for (a, change) in a.iter().zip(&self.changes[j].0) {
                if *change != 0.0 {
                    add(&mut next, a, change * factor);
                }
            }
            self.columns[j] = next;
        }
        self.take_changes(ratio, active);
    }

    fn take_changes(&mut self, ratio: [f64; 2], active: &Active) {
        for &j in active.columns() {
            self.changes[j] = moving(&self.columns[j], ratio);
        }
    }
}

impl Node {
    fn add(&mut self, term: &Term, active: &Active) {
        self.power *= self.at;
        for &j in active.columns() {
            add(&mut self.moving[j], &term.changes[j], self.power);
            self.omega_o[j] += self.power * term.columns[j][O];
        }
    }
}

/// The torque that ω_o loses power with at a node, `t` [s] into the span, by what moves: turning wheels alone lose
/// nothing.
fn lost_torque(systems: &Systems, set: usize, node: &Node, t: f64) -> [f64; ENTRIES] {
    let row = Row::sum(&systems.by_stuck[set & 3].rows.mesh, systems.mesh_loss);
    let moving = Lanes(MOVING_STATES.map(|j| row.by_state(j)));
    core::array::from_fn(|j| {
        let torque = match j {
            ..TORQUE_COLUMN => 0.0,
            TORQUE_COLUMN..RAMP_COLUMN => row.of_torque(j - TORQUE_COLUMN, 1.0),
            _ => row.of_torque(j - RAMP_COLUMN, t),
        };
        dot(&moving, &node.moving[j]) + torque
    })
}

/// Nodes of Gauss' three-point rule on [0, 1] with their weights, the numbers that move as they start.
fn nodes() -> [Node; NODES] {
    let reach = ComplexField::sqrt(0.6_f64);
    let mut moving = [Lanes::ZERO; ENTRIES];
    for (j, column) in moving[..MOVING].iter_mut().enumerate() {
        column.0[j] = 1.0;
    }
    let places = [(1.0 - reach, 5.0), (1.0, 8.0), (1.0 + reach, 5.0)];
    places.map(|(twice, eighteenths)| Node {
        at: 0.5 * twice,
        power: 1.0,
        weight: eighteenths / 18.0,
        moving,
        omega_o: [0.0; ENTRIES],
    })
}
