//! Plugin of QEMU that counts what marked parts of a firmware execute: exactly, and the same in every run.
//!
//! The firmware calls the function `bench_mark` with the number of a region: what ran since the call before belongs to
//! that region. The function stores one word into a table that is aligned to its size of [`REGIONS`] words; its address
//! tells the number. Its own instructions are not counted. Region [`REGIONS`] - 1 ends a part: the counts of every
//! region in use are written as a line
//!
//!     part region instructions loads stores taken-branches cycles
//!
//! and start again from zero. Cycles are a model, see [`cost`]. At the end the functions are listed that the measured
//! regions spent their instructions in, as lines `function name instructions`.
//!
//! Arguments: `model=m0plus|m4|ibex`, `out=FILE`.

mod cost;
mod qemu;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, OnceLock};

use cost::{Cost, Model};
use qemu::Instruction;

/// Function of the firmware that marks a region.
const MARK: &str = "bench_mark";
/// Number of regions. The last one ends a part.
const REGIONS: usize = 64;

/// Everything that ran so far outside of the marks. QEMU adds to them from the code that it generates.
static NOW: [AtomicU64; 5] = [const { AtomicU64::new(0) }; 5];
const INSTRUCTIONS: usize = 0;
const LOADS: usize = 1;
const STORES: usize = 2;
const BRANCHES: usize = 3;
const CYCLES: usize = 4;

/// Address after the block that ran last, and the cycles that it costs not to go on there.
static NEXT: AtomicU64 = AtomicU64::new(0);
static PENALTY: AtomicU64 = AtomicU64::new(0);

static MODEL: OnceLock<Model> = OnceLock::new();
static BOOK: Mutex<Option<Book>> = Mutex::new(None);

type Counts = [u64; 5];

/// What was counted.
struct Book {
    out: BufWriter<File>,
    part: u32,
    last: Counts,
    regions: [Counts; REGIONS],
    functions: BTreeMap<String, &'static Function>,
}

/// Instructions of a function: so far, at the last mark, and in the measured regions.
#[derive(Default)]
struct Function {
    now: AtomicU64,
    last: AtomicU64,
    measured: AtomicU64,
}

impl Book {
    /// What ran since the last mark belongs to this region.
    fn mark(&mut self, region: usize) {
        let now = NOW.each_ref().map(|count| count.load(Relaxed));
        if let Some(sums) = self.regions.get_mut(region) {
            for ((sum, now), last) in sums.iter_mut().zip(now).zip(self.last) {
                *sum += now - last;
            }
        }
        self.last = now;
        let is_measured = (1..REGIONS - 1).contains(&region);
        for function in self.functions.values() {
            let now = function.now.load(Relaxed);
            let spent = now - function.last.swap(now, Relaxed);
            if is_measured {
                function.measured.fetch_add(spent, Relaxed);
            }
        }
        if region == REGIONS - 1 {
            self.end_part();
        }
    }

    fn end_part(&mut self) {
        let regions = std::mem::replace(&mut self.regions, [Counts::default(); REGIONS]);
        let used = regions.iter().enumerate().take(REGIONS - 1).skip(1).filter(|(_, counts)| counts[0] > 0);
        for (region, [instructions, loads, stores, branches, cycles]) in used {
            let part = self.part;
            // The reader misses a line that could not be written.
            _ = writeln!(self.out, "{part} {region} {instructions} {loads} {stores} {branches} {cycles}");
        }
        self.part += 1;
    }

    fn close(&mut self) {
        for (name, function) in &self.functions {
            let measured = function.measured.load(Relaxed);
            if measured > 0 {
                _ = writeln!(self.out, "function {name} {measured}");
            }
        }
        _ = self.out.flush();
    }

    /// The counter of a function.
    fn function(&mut self, name: String) -> &'static Function {
        self.functions.entry(name).or_insert_with(|| Box::leak(Box::default()))
    }
}

/// Sets the plugin up; `false` for wrong arguments.
fn set_up(arguments: &[String]) -> bool {
    let mut out = None;
    for argument in arguments {
        match argument.split_once('=') {
            Some(("model", name)) => match Model::named(name) {
                Some(model) => _ = MODEL.set(model),
                None => return false,
            },
            Some(("out", path)) => out = File::create(path).ok(),
            _ => return false,
        }
    }
    let (Some(out), Some(_), Ok(mut book)) = (out, MODEL.get(), BOOK.lock()) else { return false };
    *book = Some(Book {
        out: BufWriter::new(out),
        part: 0,
        last: Counts::default(),
        regions: [Counts::default(); REGIONS],
        functions: BTreeMap::new(),
    });
    true
}

/// A stretch of code that runs from its start to its end.
struct Block {
    start: u64,
    end: u64,
    penalty: u64,
    is_counted: bool,
}

impl Block {
    /// It runs.
    fn enter(&self) {
        if self.start != NEXT.load(Relaxed) && self.is_counted {
            NOW[BRANCHES].fetch_add(1, Relaxed);
            NOW[CYCLES].fetch_add(PENALTY.load(Relaxed), Relaxed);
        }
        NEXT.store(self.end, Relaxed);
        PENALTY.store(self.penalty, Relaxed);
    }
}

/// QEMU has translated a block: says what is to be added to which count whenever it runs.
fn translated(instructions: &[Instruction], start: u64) -> Option<(Block, Vec<(&'static AtomicU64, u64)>)> {
    let model = *MODEL.get()?;
    let name = instructions.first()?.function().unwrap_or_else(|| "?".to_owned());
    let mut block = Block { start, end: start, penalty: 0, is_counted: name != MARK };
    let mut before = Cost::default();
    let mut sums = Counts::default();
    for instruction in instructions {
        let code = instruction.code();
        let cost = model.cost(code, &before);
        block.end = instruction.address() + code.len() as u64;
        block.penalty = cost.branch;
        if !block.is_counted && cost.stores == 1 && !cost.is_on_stack {
            instruction.tell_stores();
        }
        sums[INSTRUCTIONS] += 1;
        sums[LOADS] += cost.loads;
        sums[STORES] += cost.stores;
        sums[CYCLES] += cost.cycles;
        before = cost;
    }
    if !block.is_counted {
        return Some((block, Vec::new()));
    }
    let function = BOOK.lock().ok()?.as_mut()?.function(name);
    let counts = NOW.iter().zip(sums).filter(|&(_, sum)| sum > 0);
    Some((block, counts.chain([(&function.now, sums[INSTRUCTIONS])]).collect()))
}

/// The firmware has stored the word of a region.
fn marked(address: u64) {
    if let Ok(mut book) = BOOK.lock()
        && let Some(book) = book.as_mut()
    {
        book.mark(address as usize / size_of::<u32>() % REGIONS);
    }
}

fn ended() {
    if let Ok(mut book) = BOOK.lock()
        && let Some(book) = book.as_mut()
    {
        book.close();
    }
}
