//! Rows of an HM01B0: from its pins by PIO and DMA into a ring of rows, and out of it to the head.

use concentric::head::FrameStart;
use concentric::head::asynch::RowSource;
use embassy_futures::select::{Either, select};
use embassy_rp::dma;
use embassy_rp::gpio::Input;
use embassy_rp::i2c::{self, I2c};
use embassy_rp::peripherals::{I2C1, PIO0};
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{Common, Config, FifoJoin, Pin, ShiftConfig, ShiftDirection, StateMachine};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::zerocopy_channel::{Receiver, Sender};

use crate::{HEIGHT, WIDTH};

/// Address of the sensor.
const ADDRESS: u16 = 0x24;
/// Registers and values: reset, eight data lines, streaming.
const SET_UP: [(u16, u8); 3] = [(0x0103, 0x01), (0x3059, 0x02), (0x0100, 0x01)];

/// A row on its way from the sensor to the head.
pub struct Row {
    words: [u32; WIDTH / 4],
    /// Number of its frame, 1 for the first.
    frame: u32,
    /// Number in it, 0 for the first.
    number: u16,
    /// Pixels were lost before its end.
    torn: bool,
}

impl Row {
    /// An empty row.
    pub const EMPTY: Self = Self { words: [0; WIDTH / 4], frame: 0, number: 0, torn: false };
}

/// The ends of the ring of rows.
pub type RowSender = Sender<'static, CriticalSectionRawMutex, Row>;
pub type RowReceiver = Receiver<'static, CriticalSectionRawMutex, Row>;

/// Starts the sensor.
///
/// # Errors
/// It does not answer.
pub fn set_up(bus: &mut I2c<'_, I2C1, i2c::Blocking>) -> Result<(), i2c::Error> {
    for (register, value) in SET_UP {
        let [high, low] = register.to_be_bytes();
        bus.blocking_write(ADDRESS, &[high, low, value])?;
    }
    Ok(())
}

/// Prepares the state machine that collects pixels. `pins` are the eight data lines, line valid and pixel clock, in the order of
/// their numbers.
pub fn prepare(
    common: &mut Common<'static, PIO0>,
    machine: &mut StateMachine<'static, PIO0, 0>,
    pins: &[&Pin<'static, PIO0>; 10],
) {
    // A byte for each rising edge of the pixel clock while the line is valid, four of them to a word.
    let program =
        pio_asm!(".wrap_target", "wait 1 pin 8", "wait 1 pin 9", "in pins, 8", "wait 0 pin 9", ".wrap",);
    let mut config = Config::default();
    config.use_program(&common.load_program(&program.program), &[]);
    config.set_in_pins(pins);
    // Shifted to the right, the first pixel ends up in the lowest byte.
    config.shift_in = ShiftConfig { threshold: 32, direction: ShiftDirection::Right, auto_fill: true };
    config.fifo_join = FifoJoin::RxOnly;
    machine.set_config(&config);
}

/// Fills the ring, for ever. Runs above the head, which may be in the middle of a target when the next row is there. The ring
/// holds a frame; while the head has not taken all rows of the last one, new frames are left out as a whole.
pub async fn capture(
    mut machine: StateMachine<'static, PIO0, 0>,
    mut channel: dma::Channel<'static>,
    mut frame_valid: Input<'static>,
    mut ring: RowSender,
) -> ! {
    let mut frame = 0u32;
    loop {
        frame_valid.wait_for_rising_edge().await;
        frame = frame.wrapping_add(1);
        if !ring.is_empty() {
            continue;
        }
        machine.set_enable(false);
        machine.clear_fifos();
        machine.restart();
        // Clears the mark of lost pixels.
        let _ = machine.rx().stalled();
        machine.set_enable(true);
        for number in 0..HEIGHT as u16 {
            let Some(row) = ring.try_send() else { break };
            let pull = machine.rx().dma_pull(&mut channel, &mut row.words, false);
            if let Either::Second(()) = select(pull, frame_valid.wait_for_low()).await {
                break;
            }
            (row.frame, row.number, row.torn) = (frame, number, machine.rx().stalled());
            ring.send_done();
        }
    }
}

/// What can go wrong with a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorError {
    /// A frame ended early, or the DMA was too slow for the sensor.
    RowsLost,
}

/// The ring as a source of rows.
pub struct Sensor {
    ring: RowReceiver,
    frame: u32,
    next: u16,
}

impl Sensor {
    /// A source of the rows in the ring.
    pub fn new(ring: RowReceiver) -> Self {
        Self { ring, frame: 0, next: 0 }
    }
}

impl RowSource for Sensor {
    type Error = SensorError;

    async fn start(&mut self) -> Result<FrameStart, SensorError> {
        loop {
            let row = self.ring.receive().await;
            if row.number == 0 {
                (self.frame, self.next) = (row.frame, 0);
                return Ok(FrameStart { seq: row.frame, width: WIDTH as u16, height: HEIGHT as u16 });
            }
            self.ring.receive_done();
        }
    }

    async fn read_row(&mut self, to: &mut [u8]) -> Result<(), SensorError> {
        let row = self.ring.receive().await;
        // A row of another frame stays in the ring: it may be the first one.
        if (row.frame, row.number) != (self.frame, self.next) {
            return Err(SensorError::RowsLost);
        }
        let torn = row.torn;
        for (pixels, word) in to.chunks_exact_mut(4).zip(row.words) {
            pixels.copy_from_slice(&word.to_le_bytes());
        }
        self.ring.receive_done();
        self.next += 1;
        if torn { Err(SensorError::RowsLost) } else { Ok(()) }
    }
}
