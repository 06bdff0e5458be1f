//! Sensors that are not perfect.

use dct_driveline::observer::Sample;

/// A random generator that gives the same numbers everywhere (SplitMix64).
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Normal with mean 0 and deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// No error at all.
pub fn perfect(sample: Sample) -> Sample {
    sample
}

/// White noise of deviation `sigma` [rad/s] on the four speeds.
pub fn noisy(sigma: f64, seed: u64) -> impl FnMut(Sample) -> Sample {
    let mut random = Random(seed);
    move |mut sample| {
        sample.omega_e += sigma * random.normal();
        sample.omega_w += sigma * random.normal();
        for omega_c in &mut sample.omega_c {
            *omega_c += sigma * random.normal();
        }
        sample
    }
}

/// T_e reads 5 % and 2 N·m too high.
pub fn torque_error(mut sample: Sample) -> Sample {
    sample.t_e = 1.05 * sample.t_e + 2.0;
    sample
}

/// T_e reads 5 % and 2 N·m too low.
pub fn torque_deficit(mut sample: Sample) -> Sample {
    sample.t_e = 0.95 * sample.t_e - 2.0;
    sample
}

/// T_e reads 2 N·m too high.
pub fn torque_offset(mut sample: Sample) -> Sample {
    sample.t_e += 2.0;
    sample
}

/// The wheel speed reads 0.01 rad/s too high.
pub fn wheel_bias(mut sample: Sample) -> Sample {
    sample.omega_w += 0.01;
    sample
}

/// Speeds from counting encoder ticks over a step of `h` [s]: the angle is quantised.
pub fn encoder(ticks: f64, h: f64) -> impl FnMut(Sample) -> Sample {
    let mut angle = [0.0_f64; 4];
    move |mut sample| {
        let [one, two] = sample.omega_c;
        let mut speeds = [sample.omega_e, one, two, sample.omega_w];
        let step = std::f64::consts::TAU / ticks;
        for (angle, speed) in angle.iter_mut().zip(&mut speeds) {
            let next = *angle + *speed * h;
            *speed = ((next / step).floor() - (*angle / step).floor()) * step / h;
            *angle = next;
        }
        [
            sample.omega_e,
            sample.omega_c[0],
            sample.omega_c[1],
            sample.omega_w,
        ] = speeds;
        sample
    }
}

/// Speeds one step late.
pub fn delayed() -> impl FnMut(Sample) -> Sample {
    let mut last: Option<Sample> = None;
    move |sample| {
        let old = last.replace(sample).unwrap_or(sample);
        Sample {
            omega_e: old.omega_e,
            omega_c: old.omega_c,
            omega_w: old.omega_w,
            ..sample
        }
    }
}

/// One sample in a hundred is the one before.
pub fn dropping(seed: u64) -> impl FnMut(Sample) -> Sample {
    let (mut random, mut last) = (Random(seed), None);
    move |sample| {
        let kept = if random.uniform() < 0.01 {
            last.unwrap_or(sample)
        } else {
            sample
        };
        last = Some(kept);
        kept
    }
}

/// Four times in a second one of the speeds, each in turn, is `wrong` [rad/s] for a sample; samples are `h` [s] apart.
pub fn glitching(wrong: f64, h: f64) -> impl FnMut(Sample) -> Sample {
    let every = (0.25 / h).round() as usize;
    let mut index = 0;
    move |sample| {
        let mut speeds = sample.speeds();
        if index % every == every / 2 {
            speeds[index / every % 4] = wrong;
        }
        index += 1;
        sample.with_speeds(speeds)
    }
}
