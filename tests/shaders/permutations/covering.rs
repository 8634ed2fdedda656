//! Few rows in which any two choices meet: nearly every shader error shows with at most two definitions.

use std::collections::HashSet;

use kit::random::Random;

/// Choices that exclude each other; each is a set of definitions.
pub type Factor = &'static [&'static [&'static str]];

/// One choice of each factor.
type Row = Vec<usize>;

/// Random rows in addition to those.
pub const RANDOM_ROWS: usize = 200;
/// Candidates for the next row, of which the one with the most new pairs is taken.
const CANDIDATES: usize = 100;

fn pairs(row: &Row) -> impl Iterator<Item = [(usize, usize); 2]> {
    (0..row.len()).flat_map(move |j| (0..j).map(move |i| [(i, row[i]), (j, row[j])]))
}

/// Every pair of choices of two factors.
fn all_pairs(factors: &[Factor]) -> HashSet<[(usize, usize); 2]> {
    let choices = |factor: usize| (0..factors[factor].len()).map(move |choice| (factor, choice));
    (0..factors.len())
        .flat_map(|j| (0..j).map(move |i| (i, j)))
        .flat_map(|(i, j)| choices(i).flat_map(move |a| choices(j).map(move |b| [a, b])))
        .collect()
}

/// Rows that contain every pair of choices: the first and the last choices of all factors, then greedily chosen ones, then random ones.
pub fn covering_rows(factors: &[Factor]) -> Vec<Vec<&'static [&'static str]>> {
    let mut random = Random::new(1);
    let mut missing = all_pairs(factors);
    let mut rows: Vec<Row> = vec![
        vec![0; factors.len()],
        factors.iter().map(|factor| factor.len() - 1).collect(),
    ];
    for row in &rows {
        pairs(row).for_each(|pair| _ = missing.remove(&pair));
    }
    let random_row = |random: &mut Random| -> Row {
        factors
            .iter()
            .map(|factor| random.below(factor.len()))
            .collect()
    };
    while let Some(seed) = missing.iter().min().copied() {
        let mut candidate = || {
            let mut row = random_row(&mut random);
            seed.into_iter()
                .for_each(|(factor, choice)| row[factor] = choice);
            row
        };
        let best = (0..CANDIDATES)
            .map(|_| candidate())
            .max_by_key(|row| pairs(row).filter(|pair| missing.contains(pair)).count());
        let Some(row) = best else { break };
        pairs(&row).for_each(|pair| _ = missing.remove(&pair));
        rows.push(row);
    }
    rows.extend((0..RANDOM_ROWS).map(|_| random_row(&mut random)));
    rows.into_iter()
        .map(|row| {
            row.into_iter()
                .zip(factors)
                .map(|(choice, factor)| factor[choice])
                .collect()
        })
        .collect()
}
