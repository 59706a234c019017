//! Reservoir: one of many, by weight, in one look at each \[E24\]. Twin: shaders/lights/reservoir.wgsl.

/// What choices so far have left.
#[derive(Debug, Clone, Copy)]
pub struct Reservoir {
    /// Sum of the weights so far.
    pub total: f32,
    /// Uniform in [0, 1), whatever was kept so far.
    pub choice: f32,
}

impl Reservoir {
    /// Nothing kept yet; `choice` uniform in [0, 1).
    pub fn new(choice: f32) -> Self {
        Self { total: 0.0, choice }
    }

    /// True where the next one, of this weight, takes the place of the one that was kept: with probability weight/total.
    /// One number serves all choices: what is left of it is uniform again.
    pub fn takes(&mut self, weight: f32) -> bool {
        if weight <= 0.0 {
            return false;
        }
        self.total += weight;
        let part = weight / self.total;
        let taken = self.choice < part;
        let left = if taken { self.choice / part } else { (self.choice - part) / (1.0 - part) };
        // below one, which rounding may reach
        self.choice = left.min(1.0f32.next_down());
        taken
    }
}
