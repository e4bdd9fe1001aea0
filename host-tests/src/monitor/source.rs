//! Where a stream comes from.

use std::{
    fs::File,
    io::{self, ErrorKind, Read, Write},
    net::TcpStream,
    path::PathBuf,
    str::FromStr,
    sync::mpsc::{Receiver, SyncSender, sync_channel},
    thread,
    time::Duration,
};

use anyhow::{Result, ensure};

use super::ask::{self, Word};

/// Where a stream comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// Standard input.
    Stdin,
    /// `host:port` to connect to.
    Tcp(String),
    /// Name of a serial port.
    Serial(String),
    /// A file; what grows at its end later is not waited for.
    File(PathBuf),
}

const SERIAL: [&str; 4] = ["/dev/tty", "/dev/pts/", "/dev/serial/", "/dev/cu."];

impl FromStr for Source {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "-" {
            return Ok(Self::Stdin);
        }
        if let Some(address) = text.strip_prefix("tcp:") {
            let port = address.rsplit_once(':').filter(|(host, _)| !host.is_empty());
            let port = port.and_then(|(_, port)| port.parse::<u16>().ok()).unwrap_or(0);
            ensure!(port > 0, "wanted tcp:HOST:PORT with a port of 1 to 65535, as in tcp:localhost:5000");
            return Ok(Self::Tcp(address.to_owned()));
        }
        let com = text.strip_prefix("COM").is_some_and(|number| number.parse::<u8>().is_ok());
        if com || SERIAL.iter().any(|prefix| text.starts_with(prefix)) {
            return Ok(Self::Serial(text.to_owned()));
        }
        Ok(Self::File(text.into()))
    }
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stdin => f.write_str("standard input"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Serial(name) => f.write_str(name),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

impl Source {
    /// Whether somebody at the other end can be told something.
    pub(super) fn has_way_back(&self) -> bool {
        matches!(self, Self::Tcp(_) | Self::Serial(_))
    }

    /// Opens the source and reads it to its end in a thread of its own, so that waiting can be limited whatever it
    /// is. The channel closes at the end; an error is the last thing in it. Another thread sends the commands; it takes the
    /// tags of the answers from `answered`.
    pub(super) fn read(
        self,
        baud: u32,
        commands: Vec<Word>,
        answered: Receiver<u16>,
    ) -> Receiver<io::Result<Vec<u8>>> {
        let (sender, receiver) = sync_channel(16);
        thread::spawn(move || {
            let errors = sender.clone();
            let talk = |mut output: Box<dyn Write + Send>| {
                thread::spawn(move || {
                    if let Err(error) = ask::send(&commands, &mut *output, &answered) {
                        // Nobody listens any more: nobody wants to know.
                        let _ = errors.send(Err(error));
                    }
                });
            };
            let open = self.open(baud).map(|(input, output)| {
                output.map(talk);
                input
            });
            if let Err(error) = open.and_then(|input| pass_on(input, &sender)) {
                let _ = sender.send(Err(error));
            }
        });
        receiver
    }

    fn open(self, baud: u32) -> io::Result<Ends> {
        Ok(match self {
            Self::Stdin => (Box::new(io::stdin()), None),
            Self::Tcp(address) => {
                let stream = TcpStream::connect(address)?;
                (Box::new(stream.try_clone()?), Some(Box::new(stream)))
            }
            Self::Serial(name) => {
                let port = serialport::new(name, baud).timeout(Duration::from_secs(1)).open()?;
                let output: Box<dyn Write + Send> = Box::new(port.try_clone()?);
                (Box::new(port), Some(output))
            }
            Self::File(path) => (Box::new(File::open(path)?), None),
        })
    }
}

/// What is read from, and what can be written to.
type Ends = (Box<dyn Read>, Option<Box<dyn Write + Send>>);

fn pass_on(mut input: Box<dyn Read>, sender: &SyncSender<io::Result<Vec<u8>>>) -> io::Result<()> {
    let mut buffer = vec![0; 1 << 16];
    loop {
        match input.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(len) => {
                if sender.send(Ok(buffer[..len].to_vec())).is_err() {
                    return Ok(());
                }
            }
            // A serial port that is silent for a second.
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            // The other end of the serial line is gone.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => return Ok(()),
            Err(error) => return Err(error),
        }
    }
}
