//! Tables: values over wavelength, linear between them.
//!
//! `published` reads those that the program carries, from `tables.txt`, which `scripts/spectral-tables.py` makes.

use std::collections::BTreeMap;
use std::sync::LazyLock;

/// What a table is outside of its wavelengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Its first or last value: reflectances and indices.
    Held,
    /// Zero: emission.
    Zero,
}

/// Values over wavelength, linear between.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// nm, ascending.
    lambdas: Vec<f64>,
    /// One per wavelength, in whatever unit.
    values: Vec<f64>,
    outside: Outside,
}

impl Table {
    /// A table of `lambdas`, nm, and as many `values`; says what is wrong with them.
    pub fn new(lambdas: Vec<f64>, values: Vec<f64>, outside: Outside) -> Result<Self, String> {
        if lambdas.len() != values.len() {
            return Err(format!("{} wavelengths, but {} values", lambdas.len(), values.len()));
        }
        if lambdas.len() < 2 {
            return Err(format!("a spectrum needs two wavelengths or more, this has {}", lambdas.len()));
        }
        if let Some(x) = lambdas.iter().find(|x| !x.is_finite() || **x <= 0.0) {
            return Err(format!("{x} is not a wavelength in nm"));
        }
        if let Some(w) = lambdas.windows(2).find(|w| w[0] >= w[1]) {
            return Err(format!("wavelengths must ascend, but {} nm comes before {} nm", w[0], w[1]));
        }
        if let Some((x, v)) = lambdas.iter().zip(&values).find(|(_, v)| !v.is_finite() || **v < 0.0) {
            return Err(format!("the value at {x} nm is {v}, but must be zero or more"));
        }
        Ok(Self { lambdas, values, outside })
    }

    /// Value at `lambda`, nm.
    pub fn at(&self, lambda: f64) -> f64 {
        let (first, last) = (0, self.lambdas.len() - 1);
        let is_outside = lambda < self.lambdas[first] || lambda > self.lambdas[last];
        if is_outside && self.outside == Outside::Zero {
            return 0.0;
        }
        let above = self.lambdas.partition_point(|x| *x <= lambda);
        if above == 0 || above > last {
            return self.values[if above == 0 { first } else { last }];
        }
        let (a, b) = (self.lambdas[above - 1], self.lambdas[above]);
        let t = (lambda - a) / (b - a);
        (1.0 - t) * self.values[above - 1] + t * self.values[above]
    }

    /// Wavelengths, nm, ascending.
    pub fn lambdas(&self) -> &[f64] {
        &self.lambdas
    }

    /// Values, one per wavelength.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// What it is outside of its wavelengths.
    pub fn outside(&self) -> Outside {
        self.outside
    }
}

/// Tables that the program carries, by name; zero outside of their wavelengths.
static PUBLISHED: LazyLock<BTreeMap<&str, Table>> = LazyLock::new(|| {
    let lines = include_str!("tables.txt").lines().filter(|l| !l.starts_with('#'));
    lines.map(|line| parse(line).unwrap_or_else(|e| panic!("src/spectrum/tables.txt: {e}"))).collect()
});

/// A line `name first_nm step_nm values`.
fn parse(line: &str) -> Result<(&str, Table), String> {
    let (name, rest) = line.split_once(' ').ok_or("an empty line")?;
    let numbers: Result<Vec<f64>, _> = rest.split(' ').map(str::parse::<f64>).collect();
    let numbers = numbers.map_err(|e| format!("{name}: {e}"))?;
    let [first, step, values @ ..] = &numbers[..] else { return Err(format!("{name} has no values")) };
    let lambdas = (0..values.len()).map(|i| first + step * i as f64).collect();
    Ok((name, Table::new(lambdas, values.to_vec(), Outside::Zero)?))
}

/// A table of `tables.txt`. Panics where there is none of that name.
pub(super) fn published(name: &str) -> &'static Table {
    PUBLISHED.get(name).unwrap_or_else(|| panic!("src/spectrum/tables.txt has no {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_points() {
        let of = |outside| Table::new(vec![400.0, 500.0, 520.0], vec![1.0, 3.0, 2.0], outside).unwrap();
        let held = of(Outside::Held);
        for (lambda, value) in [(400.0, 1.0), (425.0, 1.5), (500.0, 3.0), (515.0, 2.25), (520.0, 2.0)] {
            assert_eq!(held.at(lambda), value);
            assert_eq!(of(Outside::Zero).at(lambda), value);
        }
        assert_eq!((held.at(399.0), held.at(521.0)), (1.0, 2.0));
        assert_eq!((of(Outside::Zero).at(399.0), of(Outside::Zero).at(521.0)), (0.0, 0.0));
    }

    #[test]
    fn wrong_tables_are_refused() {
        let wrong = |lambdas: &[f64], values: &[f64]| {
            Table::new(lambdas.to_vec(), values.to_vec(), Outside::Held).unwrap_err()
        };
        assert!(wrong(&[400.0], &[1.0]).contains("two wavelengths"));
        assert!(wrong(&[400.0, 500.0], &[1.0]).contains("but 1 values"));
        assert!(wrong(&[400.0, 400.0], &[1.0, 1.0]).contains("ascend"));
        assert!(wrong(&[400.0, f64::NAN], &[1.0, 1.0]).contains("NaN is not a wavelength"));
        assert!(wrong(&[-1.0, 400.0], &[1.0, 1.0]).contains("-1 is not a wavelength"));
        assert!(wrong(&[400.0, 500.0], &[1.0, f64::INFINITY]).contains("at 500 nm is inf"));
        assert!(wrong(&[400.0, 500.0], &[-0.5, 1.0]).contains("at 400 nm is -0.5"));
    }
}
