//! Meshes of rigid shafts: chosen together with the modes of the clutches.
//!
//! A rigid shaft passes on at once what its clutch gives it, less what turns it itself,
//!
//! ```text
//! i_f T_t = g (T_c − J_ct g ω̇_o),
//! ```
//!
//! so that its sign follows the torques of the clutches and jumps with them. With the torques of slipping
//! clutches given, Σ i_f T_t η^s − T_o − J_o ω̇_o falls as ω̇_o rises, whatever the signs: one set of signs and one
//! direction are consistent, and the sets are tried until they are found. The output stands jammed on the same terms as
//! behind compliant shafts, with i_f T_t = g T_c; with both clutches engaged: `plant/tie.rs`.

use crate::Params;
use crate::integrate::Ladders;
use crate::matrices::{O, Systems, Torques};
use crate::plant::Plant;
use crate::plant::block::torques;
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Event, GUARD_TOLERANCE, Mode, stuck_set};
use crate::plant::ports::{Input, InputRate};

impl Plant {
    /// Whether rigid shafts have a gear that loses power.
    #[inline(always)]
    pub(crate) fn has_rigid_meshes(&self, p: &Params) -> bool {
        p.rigid && p.gears_lose_power() && p.gears_that_lose(self.gear_in()) != [false; 2]
    }

    /// Takes the modes of meshes, brake and clutches that are consistent after `event`.
    #[cold]
    #[inline(never)]
    pub(crate) fn resolve_rigid(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
        event: &Event,
    ) {
        let standing = self.output_stands(event);
        if standing {
            self.stop_output(p);
        }
        let (start, loses) = (*self, p.gears_that_lose(self.gear_in()));
        let may_tie = standing && start.may_tie(p, input, rate, event);
        for meshes in start.candidates(loses, standing) {
            *self = Self { meshes, ..start };
            self.resolve_brake(p, input, rate, event);
            let systems = &ladders.of(p, self.coupling()).systems;
            self.resolve(p, systems, input, rate, event);
            let vain = may_tie && self.slips_in_vain(p, systems, input);
            if !vain && self.meshes_hold(p, systems, input, standing) {
                return;
            }
        }
        if may_tie {
            let meshes = Meshes::JAMMED;
            *self = Self { meshes, ..start };
            self.resolve_brake(p, input, rate, event);
            self.stand_tied(&ladders.of(p, self.coupling()).systems);
        }
    }

    /// The meshes as they are, then all that they could be; the last ones stay if round-off lets none hold, at
    /// standstill the jammed ones.
    fn candidates(&self, loses: [bool; 2], standing: bool) -> impl Iterator<Item = Meshes> + use<> {
        let outputs = if standing {
            [Mode::Forward, Mode::Backward, Mode::Stuck]
        } else {
            [Mode::slipping(self.x[O]); 3]
        };
        let moving = move |output: Mode, k: usize| {
            let sign = |i: usize| [Mode::Forward, Mode::Backward][k >> i & 1];
            Meshes {
                load: [0, 1].map(|i| if loses[i] { sign(i) } else { Mode::Open }),
                output,
            }
        };
        let tried = if standing { 2 } else { 1 };
        let all = (0..tried).flat_map(move |j| (0..4).map(move |k| moving(outputs[j], k)));
        let jam = standing.then_some(Meshes::JAMMED);
        let was = self.meshes;
        let kept = [0, 1]
            .into_iter()
            .all(|i| (was.load[i] != Mode::Open) == (loses[i] && was.output != Mode::Stuck));
        let first = (kept && outputs.contains(&was.output)).then_some(was);
        first.into_iter().chain(jam).chain(all).chain(jam)
    }

    /// Whether the meshes are loaded and turn as they were taken to be.
    fn meshes_hold(&self, p: &Params, systems: &Systems, input: &Input, standing: bool) -> bool {
        let v = self.torques_now(p, input);
        let system = &systems.by_stuck[stuck_set(self.modes)];
        let torque = system.rows.mesh.map(|row| row.of(&self.x, &v));
        let output = self.meshes.output;
        if output == Mode::Stuck {
            let [forward, backward] = self.urges(p, &self.x, torque);
            return self.is_tied(p) || forward <= GUARD_TOLERANCE && backward >= -GUARD_TOLERANCE;
        }
        let loaded = |i: usize| self.meshes.load[i].direction() * torque[i] >= -GUARD_TOLERANCE;
        let leaves = !standing || output.direction() * system.rate(O, &self.x, &v) > 0.0;
        loaded(0) && loaded(1) && leaves
    }

    /// v with the friction torques of now; T_v moves no output.
    pub(crate) fn torques_now(&self, p: &Params, input: &Input) -> Torques {
        let factor = self.friction_factor(p);
        let v = torques(p, self.modes, factor, input.t_e, input.force, 0.0);
        self.with_synchronisers(p, v)
    }

    /// A guess at the start of a run, where no matrices of lossy meshes are at hand.
    pub(crate) fn guess_rigid_meshes(&mut self, p: &Params, systems: &Systems, input: &Input) {
        let v = self.torques_now(p, input);
        let rows = &systems.by_stuck[stuck_set(self.modes)].rows;
        let torque = rows.mesh.map(|row| row.of(&self.x, &v));
        let loses = p.gears_that_lose(self.gear_in());
        let load = |i: usize| match loses[i] {
            true => Mode::slipping(torque[i]),
            false => Mode::Open,
        };
        let output = Mode::slipping(self.x[O]);
        self.meshes = match self.output_stands(&Event::default()) {
            true => Meshes::JAMMED,
            false => Meshes {
                load: [load(0), load(1)],
                output,
            },
        };
    }
}
