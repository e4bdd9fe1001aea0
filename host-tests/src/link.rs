//! A camera head in QEMU: starts it, plays its camera, listens to its serial port.

use std::fs::{self, File};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::iter;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use concentric::Run;
use tempfile::TempDir;

use crate::picture::Picture;
use crate::render::Scene;

#[path = "../../examples/mailbox-head/src/protocol.rs"]
pub mod protocol;

use protocol::{
    ANSWER, ANSWER_WORDS, Answer, DONE, Frame, MAGIC, ORDER, ORDERED, Order, Outcome, PIXELS, READY,
};

/// A board that QEMU emulates.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Environment variable that names the firmware's ELF file.
    pub elf: &'static str,
    qemu: &'static str,
    arguments: &'static [&'static str],
    /// Its name for QEMU.
    name: &'static str,
    /// Bytes of the memory that has the mailbox, and where that begins in it.
    memory: u64,
    mailbox: u64,
}

/// A Cortex-M4F.
pub const MPS2_AN386: Machine = Machine {
    elf: "CONCENTRIC_MPS2_AN386_ELF",
    qemu: "qemu-system-arm",
    arguments: &["-semihosting-config", "enable=on,target=native"],
    name: "mps2-an386",
    memory: MAILBOX_BYTES,
    mailbox: 0,
};
/// A Cortex-M7.
pub const MPS2_AN500: Machine =
    Machine { elf: "CONCENTRIC_MPS2_AN500_ELF", name: "mps2-an500", ..MPS2_AN386 };
/// A RISC-V core without floating-point unit.
pub const RISCV_VIRT: Machine = Machine {
    elf: "CONCENTRIC_RISCV_VIRT_ELF",
    qemu: "qemu-system-riscv32",
    arguments: &["-bios", "none", "-m", "32M"],
    name: "virt",
    memory: 2 * MAILBOX_BYTES,
    mailbox: MAILBOX_BYTES,
};

/// Bytes of the mailbox of every board.
const MAILBOX_BYTES: u64 = 16 << 20;
/// Longest wait for a head that should be at work. Nothing here takes a hundredth of it.
const PATIENCE: Duration = Duration::from_secs(60);
const POLL: Duration = Duration::from_micros(200);

/// Ten frames of 6 to 60 targets, every other one with clutter between them.
///
/// # Errors
/// None that these frames can have.
pub fn sample_frames() -> Result<Vec<Picture>> {
    let render = |number: usize| {
        let scene = Scene::many(6 * number, 640, 480, number.is_multiple_of(2), number as u64)?;
        let frame = scene.render(number as u64);
        Picture::new(format!("sample {number}"), frame.width, frame.height, frame.pixels)
    };
    (1..=10).map(render).collect()
}

/// The dark runs of a row as logic finds them that compares with one threshold.
pub fn runs(row: &[u8], threshold: u8) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (x, _) in (0..).zip(row).filter(|(_, level)| **level < threshold) {
        match runs.last_mut() {
            Some(run) if run.end == x => run.end += 1,
            _ => runs.push(Run { start: x, end: x + 1 }),
        }
    }
    runs
}

/// Where the head's serial port leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Serial {
    /// To this program: [`Head::report`] reads it.
    Here,
    /// To the first program that connects to this TCP port of the local machine; the head boots when it does.
    Served(u16),
}

/// A camera head in QEMU. Dropping it stops the emulator.
pub struct Head {
    machine: Machine,
    qemu: Child,
    memory: File,
    serial: Option<TcpStream>,
    orders: u32,
    folder: TempDir,
}

impl Head {
    /// Boots the firmware `elf` on `machine` and waits until it is ready.
    ///
    /// # Errors
    /// QEMU is not there, does not start, or the firmware does not come up within a minute of its start.
    pub fn boot(machine: Machine, elf: &Path, serial: Serial) -> Result<Self> {
        ensure!(elf.is_file(), "{}: no such firmware", elf.display());
        let folder = tempfile::Builder::new().prefix("concentric-head-").tempdir()?;
        let path = folder.path().join("memory");
        let memory = File::options().read(true).write(true).create_new(true).open(&path)?;
        memory.set_len(machine.memory)?;
        let listener = TcpListener::bind("127.0.0.1:0").context("no local TCP port")?;
        let (port, server) = match serial {
            Serial::Here => (listener.local_addr()?.port(), ""),
            Serial::Served(port) => (port, ",server=on,wait=on"),
        };
        let backend = format!(
            "memory-backend-file,id=memory,size={},share=on,mem-path={}",
            machine.memory,
            path.display()
        );
        let qemu = Command::new(machine.qemu)
            .args(["-machine", &format!("{},memory-backend=memory", machine.name), "-object", &backend])
            .args(machine.arguments)
            .args(["-display", "none", "-monitor", "none"])
            .args(["-serial", &format!("tcp:127.0.0.1:{port}{server}"), "-kernel"])
            .arg(elf)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(match serial {
                Serial::Here => File::create(folder.path().join("log"))?.into(),
                Serial::Served(_) => Stdio::inherit(),
            })
            .spawn()
            .with_context(|| format!("cannot start {}", machine.qemu))?;
        let mut head = Self { machine, qemu, memory, serial: None, orders: 0, folder };
        if serial == Serial::Here {
            head.serial = Some(head.accept(&listener)?);
            head.wait_for(READY, MAGIC, Some(PATIENCE)).context("the firmware does not come up")?;
        } else {
            head.wait_for(READY, MAGIC, None)?;
        }
        Ok(head)
    }

    /// Lets the head measure a frame of `frame.width * frame.height` pixels; its sequence number in the report is 1
    /// for the first.
    ///
    /// # Errors
    /// The frame does not fit the mailbox, the head refuses it, or does not answer within a minute.
    pub fn measure(&mut self, frame: Frame, pixels: &[u8]) -> Result<Answer> {
        self.measure_by(Order::Measure(frame), (frame.width, frame.height), pixels, &[])
    }

    /// The same with the runs of each row, as found by logic that takes no difference of grey levels below `min_contrast` for an
    /// edge.
    ///
    /// # Errors
    /// As [`measure`](Self::measure).
    pub fn measure_with_runs(
        &mut self,
        frame: Frame,
        pixels: &[u8],
        runs: &[Vec<Run>],
        min_contrast: u8,
    ) -> Result<Answer> {
        let words = |runs: &Vec<Run>| {
            let first = runs.len() as u32 | u32::from(min_contrast) << 16;
            let run = |run: &Run| u32::from(run.start) | u32::from(run.end) << 16;
            iter::once(first).chain(runs.iter().map(run)).flat_map(u32::to_le_bytes).collect()
        };
        let behind: Vec<Vec<u8>> = runs.iter().map(words).collect();
        self.measure_by(Order::MeasureWithRuns(frame), (frame.width, frame.height), pixels, &behind)
    }

    /// The same as [`measure`](Self::measure) with the settings that are in force.
    ///
    /// # Errors
    /// As [`measure`](Self::measure).
    pub fn measure_as_set(&mut self, (width, height): (u32, u32), pixels: &[u8]) -> Result<Answer> {
        self.measure_by(Order::MeasureAsSet { width, height }, (width, height), pixels, &[])
    }

    /// `behind` has what follows each row.
    fn measure_by(
        &mut self,
        order: Order,
        (width, height): (u32, u32),
        pixels: &[u8],
        behind: &[Vec<u8>],
    ) -> Result<Answer> {
        let (width, height) = (width as usize, height as usize);
        ensure!(pixels.len() == width * height, "{} pixels for a frame of {width}x{height}", pixels.len());
        let room = MAILBOX_BYTES as usize - PIXELS * 4;
        let mut rows = Vec::new();
        for (y, row) in pixels.chunks_exact(width.max(1)).enumerate() {
            rows.extend_from_slice(row);
            rows.resize(rows.len().next_multiple_of(4), 0);
            rows.extend_from_slice(behind.get(y).map_or(&[], Vec::as_slice));
        }
        ensure!(rows.len() <= room, "a frame of {width}x{height} does not fit the mailbox of {room} bytes");
        self.put(PIXELS, &rows)?;
        let answer = self.order(order)?;
        ensure!(answer.outcome == Outcome::Done, "the head refuses the frame: {}", answer.outcome.reason());
        Ok(answer)
    }

    /// Gives an order and waits for the answer.
    ///
    /// # Errors
    /// The head does not answer within a minute.
    pub fn order(&mut self, order: Order) -> Result<Answer> {
        self.send(order)?;
        self.wait_for(DONE, self.orders, Some(PATIENCE)).context("the head does not answer")?;
        let words: [u32; ANSWER_WORDS] = self.words(ANSWER)?;
        Answer::from_words(words).with_context(|| format!("the head answers {words:x?}, which means nothing"))
    }

    /// The next `length` bytes of the serial port.
    ///
    /// # Errors
    /// They do not arrive within a minute, or the port leads elsewhere.
    pub fn report(&mut self, length: u32) -> Result<Vec<u8>> {
        let serial = self.serial.as_mut().context("the serial port leads to another program")?;
        let mut bytes = vec![0; length as usize];
        serial
            .read_exact(&mut bytes)
            .with_context(|| format!("the head did not send the {length} bytes of a report"))?;
        Ok(bytes)
    }

    /// Sends bytes to the head.
    ///
    /// # Errors
    /// The port leads elsewhere, or is closed.
    pub fn tell(&mut self, bytes: &[u8]) -> Result<()> {
        let serial = self.serial.as_mut().context("the serial port leads to another program")?;
        Ok(serial.write_all(bytes)?)
    }

    /// Ends the firmware with this status; gives the emulator's exit status and what the serial port still held.
    ///
    /// # Errors
    /// It does not end within a minute.
    pub fn exit(mut self, status: u8) -> Result<(ExitStatus, Vec<u8>)> {
        self.send(Order::Exit(status.into()))?;
        let began = Instant::now();
        let ended = loop {
            if let Some(ended) = self.qemu.try_wait()? {
                break ended;
            }
            ensure!(began.elapsed() < PATIENCE, "the head does not exit; the log says: {:?}", self.log());
            thread::sleep(POLL);
        };
        let mut rest = Vec::new();
        if let Some(serial) = &mut self.serial {
            serial.read_to_end(&mut rest)?;
        }
        Ok((ended, rest))
    }

    fn send(&mut self, order: Order) -> Result<()> {
        self.orders += 1;
        self.put(ORDER, order.to_words().map(u32::to_le_bytes).as_flattened())?;
        self.put(ORDERED, &self.orders.to_le_bytes())
    }

    fn accept(&mut self, listener: &TcpListener) -> Result<TcpStream> {
        listener.set_nonblocking(true)?;
        let began = Instant::now();
        let stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error.into()),
            }
            self.check_running()?;
            ensure!(
                began.elapsed() < PATIENCE,
                "{} does not open its serial port; the log says: {:?}",
                self.machine.qemu,
                self.log()
            );
            thread::sleep(POLL);
        };
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        Ok(stream)
    }

    fn wait_for(&mut self, word: usize, wanted: u32, patience: Option<Duration>) -> Result<()> {
        let began = Instant::now();
        while self.words::<1>(word)? != [wanted] {
            self.check_running()?;
            if patience.is_some_and(|patience| began.elapsed() > patience) {
                bail!("waited {} s in vain; the log says: {:?}", began.elapsed().as_secs(), self.log());
            }
            thread::sleep(POLL);
        }
        Ok(())
    }

    fn check_running(&mut self) -> Result<()> {
        match self.qemu.try_wait()? {
            Some(ended) => {
                bail!("{} ended by itself, {ended}; the log says: {:?}", self.machine.qemu, self.log())
            }
            None => Ok(()),
        }
    }

    /// What the firmware and the emulator logged; empty when that goes to the terminal ([`Serial::Served`]).
    pub fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }

    fn words<const N: usize>(&mut self, first: usize) -> Result<[u32; N]> {
        let mut bytes = [[0; 4]; N];
        self.memory.seek(SeekFrom::Start(self.machine.mailbox + first as u64 * 4))?;
        self.memory.read_exact(bytes.as_flattened_mut())?;
        Ok(bytes.map(u32::from_le_bytes))
    }

    fn put(&mut self, first: usize, bytes: &[u8]) -> Result<()> {
        self.memory.seek(SeekFrom::Start(self.machine.mailbox + first as u64 * 4))?;
        Ok(self.memory.write_all(bytes)?)
    }
}

impl Drop for Head {
    fn drop(&mut self) {
        // Fails only when it has ended already.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}
