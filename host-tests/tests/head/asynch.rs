//! The awaited head sends the bytes of the blocking one.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use concentric::head::{FrameStart, HeadError, asynch};

use crate::support::{BUFFER, Bench, Outcome, PlayedLine, SIZE, Sensor, TestStorage};

/// A sensor that lets every row be awaited twice.
struct Lazy(Sensor);

impl asynch::RowSource for Lazy {
    type Error = &'static str;

    async fn start(&mut self) -> Result<FrameStart, Self::Error> {
        wait().await;
        Ok(self.0.next_frame())
    }

    async fn read_row(&mut self, row: &mut [u8]) -> Result<(), Self::Error> {
        wait().await;
        self.0.next_row(row)
    }
}

/// Is pending once.
fn wait() -> impl Future<Output = ()> {
    let mut waited = false;
    std::future::poll_fn(
        move |_| if std::mem::replace(&mut waited, true) { Poll::Ready(()) } else { Poll::Pending },
    )
}

fn run<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    for _ in 0..10_000 {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return output;
        }
    }
    panic!("never ready");
}

fn frames(frame: fn(&mut Bench<'_>) -> Outcome) -> (Vec<Outcome>, Vec<u8>) {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::default(), &mut storage, &mut buffer);
    bench.line.0.borrow_mut().per_row = 1;
    let outcomes = [None, Some(50), None].map(|broken| {
        bench.sensor.broken = broken;
        frame(&mut bench)
    });
    bench.settle();
    (outcomes.into(), bench.line.take())
}

#[test]
fn an_awaited_sensor_gives_the_bytes_of_a_blocking_one() {
    let awaited = frames(|bench| {
        let sensor = std::mem::replace(&mut bench.sensor, Sensor::new(&bench.line));
        let mut lazy = Lazy(sensor);
        let mut row = [0; SIZE as usize];
        let outcome =
            run(bench.head.frame_async(&mut bench.detector, &mut lazy, &mut row, &mut bench.results));
        bench.sensor = lazy.0;
        outcome
    });
    let blocking = frames(|bench| bench.frame());
    assert_eq!(awaited, blocking);
    assert_eq!(awaited.0[1], Err(HeadError::Source("no line sync")));
}
