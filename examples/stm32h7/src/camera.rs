//! An MT9V034 on the DCMI as a source of rows.

use concentric::head::FrameStart;
use concentric::head::asynch::RowSource;
use embassy_futures::yield_now;
use embassy_stm32::dcmi::{self, Dcmi};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::mode::Blocking;
use embassy_stm32::peripherals::DCMI;
use embassy_time::{Duration, with_timeout};

use crate::{HEIGHT, WIDTH};

/// Address of the sensor with both address pins low.
const ADDRESS: u8 = 0x48;
/// Register of the width of the window.
const WINDOW_WIDTH: u8 = 0x04;
/// Longest wait for a frame; the sensor sends 60 a second.
const PATIENCE: Duration = Duration::from_millis(200);

/// What can go wrong with the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraError {
    /// No frame came in its time.
    Silent,
    /// The DCMI lost bytes.
    Dcmi(dcmi::Error),
}

/// Sets the sensor's window to the width of the frames. Everything else stays as it is after its reset: master mode, 480
/// rows, 60 frames a second at 26.67 MHz, automatic gain and exposure.
///
/// # Errors
/// The sensor does not answer.
pub fn set_up(bus: &mut I2c<'_, Blocking, i2c::Master>) -> Result<(), i2c::Error> {
    let [high, low] = (WIDTH as u16).to_be_bytes();
    bus.blocking_write(ADDRESS, &[WINDOW_WIDTH, high, low])
}

/// Captures a frame, then gives its rows.
pub struct Camera<'d> {
    dcmi: Dcmi<'d, DCMI>,
    frame: &'static mut [u32],
    seq: u32,
    next: usize,
}

impl<'d> Camera<'d> {
    /// A camera whose frames go into `frame`, which must have as many words as a frame.
    pub fn new(dcmi: Dcmi<'d, DCMI>, frame: &'static mut [u32]) -> Self {
        Self { dcmi, frame, seq: 0, next: 0 }
    }
}

impl RowSource for Camera<'_> {
    type Error = CameraError;

    async fn start(&mut self) -> Result<FrameStart, CameraError> {
        let capture = with_timeout(PATIENCE, self.dcmi.capture(self.frame));
        capture.await.map_err(|_| CameraError::Silent)?.map_err(CameraError::Dcmi)?;
        self.seq = self.seq.wrapping_add(1);
        self.next = 0;
        Ok(FrameStart { seq: self.seq, width: WIDTH as u16, height: HEIGHT as u16 })
    }

    async fn read_row(&mut self, row: &mut [u8]) -> Result<(), CameraError> {
        let words = self.frame.chunks_exact(WIDTH / 4).nth(self.next).unwrap_or_default();
        for (pixels, word) in row.chunks_exact_mut(4).zip(words) {
            pixels.copy_from_slice(&word.to_le_bytes());
        }
        self.next += 1;
        // The tasks of the serial port get their turn.
        yield_now().await;
        Ok(())
    }
}
