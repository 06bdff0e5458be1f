//! Reads the files of `tests/golden`; its README says what they hold.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use dct_driveline::Params;
use dct_driveline::friction::FrictionCurve;
use dct_driveline::plant::ClutchState;
use dct_driveline::plant::modes::Mode;

/// Steps of an event that round-off at the touch point may move it by; no torque behind it.
const TOUCH_STEPS: f64 = 2.0;

/// FMI name of V_ε.
const V_EPS: &str = "vehicle.rollingResistanceSpeed";

/// Columns of a CSV by name.
pub struct Table {
    columns: BTreeMap<String, Vec<f64>>,
}

/// A change of a clutch's state.
#[derive(Debug, Clone, PartialEq)]
pub struct ClutchEvent {
    pub time: f64,
    /// 0 and 1: a clutch, 2: the brake, 3 and 4: a synchroniser, 5: the output in meshes that lose power.
    part: usize,
    from: String,
    to: String,
    direction: f64,
}

/// A reference run.
pub struct Case {
    /// Step over which inputs are held [s]; None: continuous.
    pub h: Option<f64>,
    pub stop: f64,
    pub omega_e: f64,
    pub v: f64,
    pub rigid: bool,
    curves: [Option<FrictionCurve>; 2],
    /// (time [s], gears preselected from then on), the first ones at the start.
    pub gears: Vec<(f64, [i32; 2])>,
    about: String,
    pub turnover: f64,
    pub events: Vec<ClutchEvent>,
    pub scenario: Table,
    rows: Vec<Vec<f64>>,
}

impl ClutchEvent {
    pub fn new(time: f64, part: usize, from: Mode, to: Mode) -> Self {
        let name = |mode: Mode| format!("{:?}", ClutchState::from(mode)).to_lowercase();
        Self {
            time,
            part,
            from: name(from),
            to: name(to),
            direction: to.direction(),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        Self {
            time: other.time,
            ..self.clone()
        } == *other
    }

    /// Touching or opening: no torque acts yet or any more.
    fn is_touch(&self) -> bool {
        self.part < 3 && (self.from == "disengaged" || self.to == "disengaged")
    }
}

impl Table {
    fn read(name: &str) -> Self {
        let text = text(name);
        let mut lines = text.lines();
        let names: Vec<String> = lines.next().unwrap().split(',').map(String::from).collect();
        let rows: Vec<Vec<f64>> = lines
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
            .collect();
        let column = |j: usize| rows.iter().map(|row| row[j]).collect();
        Self {
            columns: names
                .into_iter()
                .enumerate()
                .map(|(j, name)| (name, column(j)))
                .collect(),
        }
    }

    /// Value of a column at `time`, linear between its rows, constant outside.
    pub fn at(&self, name: &str, time: f64) -> f64 {
        let (t, y) = (&self.columns["time"], &self.columns[name]);
        let end = t.partition_point(|t| *t <= time);
        if end == 0 {
            return y[0];
        }
        if end == t.len() {
            return y[end - 1];
        }
        let start = end - 1;
        y[start] + (y[end] - y[start]) / (t[end] - t[start]) * (time - t[start])
    }
}

impl Table {
    /// Like [`Self::at`]; 0 for a column that cases without the input leave out.
    pub fn optional(&self, name: &str, time: f64) -> f64 {
        if self.columns.contains_key(name) {
            self.at(name, time)
        } else {
            0.0
        }
    }
}

impl Case {
    /// Parameters of the case.
    pub fn params(&self) -> Params {
        let mut p = Params {
            rigid: self.rigid,
            ..Params::TABLE_1
        };
        let set = |name: &str, value: &mut f64| {
            if self.about.contains(name) {
                *value = number(&self.about, name);
            }
        };
        set(V_EPS, &mut p.road.v_eps);
        for i in [0, 1] {
            let shaft = format!("shaft{}", i + 1);
            for (k, i_t) in p.i_t[i].iter_mut().enumerate() {
                set(&format!("{shaft}.gearRatio[{}]", k + 1), i_t);
            }
            set(&format!("{shaft}.reverseRatio"), &mut p.i_r[i]);
            for (k, eta) in p.eta[i].iter_mut().enumerate() {
                set(&format!("{shaft}.gearEfficiency[{}]", k + 1), eta);
            }
            set(&format!("{shaft}.reverseEfficiency"), &mut p.eta_r[i]);
        }
        for (i, (clutch, curve)) in p.clutch.iter_mut().zip(self.curves).enumerate() {
            clutch.curve = curve.unwrap_or(clutch.curve);
            let (name, node) = (format!("clutch{}", i + 1), &mut clutch.thermal);
            set(&format!("{name}.temperature_start"), &mut node.start);
            set(&format!("{name}.thermal.capacity"), &mut node.capacity);
            set(
                &format!("{name}.thermal.conductance"),
                &mut node.conductance,
            );
            set(&format!("{name}.thermal.ambient"), &mut node.ambient);
            for k in 0..node.factor.len() {
                let point = |what: &str| format!("{name}.thermal.{what}[{}]", k + 1);
                set(&point("temperature"), &mut node.temperature[k]);
                set(&point("factor"), &mut node.factor[k]);
            }
        }
        p
    }

    /// Gears preselected at `time` [s], shape (2).
    pub fn gear(&self, time: f64) -> [i32; 2] {
        let begun = self.gears.iter().rev().find(|(t, _)| *t <= time + 1e-9);
        begun.unwrap().1
    }

    pub fn read(name: &str) -> Self {
        let about = text(&format!("{name}.json"));
        let table = text(&format!("{name}.csv"));
        let rows = table
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
        Self {
            h: field(&about, "h").parse().ok(),
            stop: number(&about, "stop"),
            omega_e: number(&about, "engine.speed_start"),
            v: number(&about, "vehicle.speed_start"),
            rigid: about.contains("\"transmission.rigid\": true"),
            curves: [1, 2].map(|clutch| curve(&about, clutch)),
            gears: gears(&about),
            turnover: number(&text(&format!("{name}.energy.json")), "turnover"),
            events: events(&text(&format!("{name}.events.json"))),
            scenario: Table::read(&field(&about, "scenario")),
            rows: rows.collect(),
            about,
        }
    }

    /// The row at `time` without its time, if there is one.
    pub fn row(&self, time: f64) -> Option<&[f64]> {
        let found = self.rows.partition_point(|row| row[0] < time - 1e-7);
        self.rows
            .get(found)
            .filter(|row| (row[0] - time).abs() < 1e-7)
            .map(|row| &row[1..])
    }

    /// Largest difference in time from the reference's events [s], which must be the same ones.
    pub fn compare_events(&self, ours: &[ClutchEvent], h: f64) -> f64 {
        let like = ours.len() == self.events.len()
            && ours
                .iter()
                .zip(&self.events)
                .all(|(ours, theirs)| ours.is_like(theirs));
        assert!(like, "events {ours:#?}\nreference {:#?}", self.events);
        let miss = |(ours, theirs): (&ClutchEvent, &ClutchEvent)| {
            let miss = (ours.time - theirs.time).abs();
            let allowed = if ours.is_touch() {
                TOUCH_STEPS * h
            } else {
                0.0
            };
            if miss <= allowed * (1.0 + 1e-9) {
                0.0
            } else {
                miss
            }
        };
        ours.iter().zip(&self.events).map(miss).fold(0.0, f64::max)
    }
}

fn text(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden");
    fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The value of a key in flat JSON, as text.
fn field(json: &str, key: &str) -> String {
    let (_, after) = json
        .split_once(&format!("\"{key}\":"))
        .unwrap_or_else(|| panic!("no {key}"));
    let end = after.find([',', '}', '\n']).unwrap();
    after[..end].trim().trim_matches('"').to_string()
}

/// The friction curve of a clutch, where the case has one.
fn curve(json: &str, clutch: usize) -> Option<FrictionCurve> {
    let name = format!("clutch{clutch}.frictionCurve");
    let values =
        |what: &str| std::array::from_fn(|k| number(json, &format!("{name}.{what}[{}]", k + 1)));
    json.contains(&name).then(|| FrictionCurve {
        slip: values("slip"),
        factor: values("factor"),
    })
}

fn number(json: &str, key: &str) -> f64 {
    field(json, key).parse().unwrap()
}

fn events(json: &str) -> Vec<ClutchEvent> {
    json.split('{')
        .skip(1)
        .map(|event| ClutchEvent {
            time: number(event, "time"),
            part: [
                "1",
                "2",
                "brake",
                "synchroniser 1",
                "synchroniser 2",
                "output",
            ]
            .iter()
            .position(|part| field(event, "clutch") == *part)
            .unwrap(),
            from: field(event, "from"),
            to: field(event, "to"),
            direction: number(event, "direction"),
        })
        .collect()
}

/// Gears at the start, then those of every shift.
fn gears(json: &str) -> Vec<(f64, [i32; 2])> {
    let pair = |json: &str, names: [&str; 2]| names.map(|name| field(json, name).parse().unwrap());
    let start = (0.0, pair(json, ["shaft1.gear", "shaft2.gear"]));
    let shifts = json
        .split_once("\"shifts\"")
        .map_or("", |(_, shifts)| shifts);
    let list = shifts.split_once(']').map_or("", |(list, _)| list);
    let shift = |text: &str| (number(text, "time"), pair(text, ["shaft1", "shaft2"]));
    let rest = list.split('{').skip(1).map(shift);
    core::iter::once(start).chain(rest).collect()
}
