//! Serves a site to browsers on the same computer.

use super::message::{Answer, Method, Request};
use anyhow::{Context, Result};
use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Longest head of a request that is read (bytes).
const LONGEST_HEAD: usize = 16 * 1024;

/// Connections served at once; more are closed.
const MOST_CONNECTIONS: usize = 64;

/// How long a connection may be silent.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long a request may take to arrive, however little is sent at a time.
const LONGEST_ARRIVAL: Duration = Duration::from_secs(15);

/// How long a refused body is read on, so that its sender sees the refusal and not a broken connection.
const LINGER: Duration = Duration::from_millis(500);

/// What is served.
pub(in crate::commands) trait Site: Send + Sync + 'static {
    /// The status of a refusal that needs no body to be read.
    fn refuses(&self, request: &Request) -> Option<&'static str>;

    /// The answer to a request that is not refused.
    fn answer(&self, request: &Request) -> Answer;
}

/// A connection that is counted as long as it is there.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Answers requests until the process ends.
pub(in crate::commands) fn serve(listener: &TcpListener, site: impl Site) -> Result<()> {
    let own = listener.local_addr().context("listening on the loopback interface")?;
    let site = Arc::new(site);
    let open = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        // A connection that was given up before it was taken is no reason to end.
        let Ok(stream) = stream else { continue };
        let before = open.fetch_add(1, Ordering::SeqCst);
        let counted = Counted(Arc::clone(&open));
        if before >= MOST_CONNECTIONS {
            continue;
        }
        let site = Arc::clone(&site);
        // Without a thread the connection is closed, like those beyond the limit.
        let _ = std::thread::Builder::new().spawn(move || {
            let _counted = counted;
            // Whoever has gone needs no answer.
            let _ = respond(stream, &*site, own);
        });
    }
    Ok(())
}

fn respond(mut stream: TcpStream, site: &dyn Site, own: SocketAddr) -> std::io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut incoming = Incoming {
        stream: &stream,
        end: Instant::now() + LONGEST_ARRIVAL,
        read: Vec::new(),
    };
    let Some(head) = incoming.head()? else { return Ok(()) };
    let (answer, has_body) = match Request::of_head(&head, own) {
        Err(status) => (Answer::refusal(status), true),
        Ok(mut request) => {
            let has_body = request.method != Method::Head;
            let length = site.refuses(&request).map_or(request.length, Err);
            match length {
                Err(status) => (Answer::refusal(status), has_body),
                Ok(length) => {
                    request.body = incoming.body(length as usize)?;
                    (site.answer(&request), has_body)
                }
            }
        }
    };
    let policy = answer
        .policy
        .map_or_else(String::new, |policy| format!("Content-Security-Policy: {policy}\r\n"));
    write!(
        stream,
        "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\n{policy}X-Content-Type-Options: nosniff\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-store\r\n\
         Connection: close\r\n\r\n",
        answer.status,
        answer.kind,
        answer.body.len()
    )?;
    if has_body {
        stream.write_all(&answer.body)?;
    }
    stream.flush()?;
    linger(&mut stream)
}

/// Reads what is still on its way, for a while.
fn linger(stream: &mut TcpStream) -> std::io::Result<()> {
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(LINGER))?;
    let end = Instant::now() + LINGER;
    let mut buffer = [0; 16 * 1024];
    while Instant::now() < end && stream.read(&mut buffer)? > 0 {}
    Ok(())
}

/// A request that arrives.
struct Incoming<'a> {
    stream: &'a TcpStream,
    /// When it must be there.
    end: Instant,
    read: Vec<u8>,
}

impl Incoming<'_> {
    /// Reads some more, and says whether there was any.
    fn more(&mut self) -> std::io::Result<bool> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(std::io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left.min(PATIENCE)))?;
        let mut buffer = [0; 16 * 1024];
        let count = self.stream.read(&mut buffer)?;
        self.read.extend_from_slice(&buffer[..count]);
        Ok(count > 0)
    }

    /// The head, or what there is of one that is too long; none of who sends nothing whole.
    fn head(&mut self) -> std::io::Result<Option<String>> {
        const END: &[u8] = b"\r\n\r\n";
        loop {
            if let Some(at) = self.read.windows(END.len()).position(|window| window == END) {
                let rest = self.read.split_off(at + END.len());
                let head = std::mem::replace(&mut self.read, rest);
                return Ok(Some(String::from_utf8_lossy(&head).into_owned()));
            }
            if self.read.len() > LONGEST_HEAD {
                return Ok(Some(String::new()));
            }
            if !self.more()? {
                return Ok(None);
            }
        }
    }

    /// The body of a length; what follows it is left.
    fn body(&mut self, length: usize) -> std::io::Result<Vec<u8>> {
        while self.read.len() < length {
            if !self.more()? {
                return Err(std::io::ErrorKind::UnexpectedEof.into());
            }
        }
        self.read.truncate(length);
        Ok(std::mem::take(&mut self.read))
    }
}
