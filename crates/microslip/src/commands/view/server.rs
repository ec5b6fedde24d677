//! Serves a page and the files of folders of results to a browser on the same computer.

use anyhow::{Context, Result};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Longest request that is read (bytes).
const LONGEST_REQUEST: usize = 16 * 1024;

/// Connections served at once; more are closed.
const MOST_CONNECTIONS: usize = 64;

/// How long a connection may be silent.
const PATIENCE: Duration = Duration::from_secs(10);

/// What is served.
#[derive(Debug)]
pub(super) struct Site {
    /// The page at the root.
    pub(super) index: String,
    /// Folders whose files are at `NUMBER/NAME`, from 1 on.
    pub(super) folders: Vec<PathBuf>,
}

/// An answer to a request.
#[derive(Debug, PartialEq, Eq)]
struct Answer {
    status: &'static str,
    kind: &'static str,
    body: Vec<u8>,
}

impl Answer {
    fn refusal(status: &'static str) -> Self {
        Self {
            status,
            kind: "text/plain; charset=utf-8",
            body: format!("{status}\n").into_bytes(),
        }
    }
}

/// Answers requests until the process ends.
pub(super) fn serve(listener: &TcpListener, site: Site) -> Result<()> {
    let own = listener.local_addr().context("listening on the loopback interface")?;
    let site = Arc::new(site);
    let open = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        // A connection that was given up before it was taken is no reason to end.
        let Ok(stream) = stream else { continue };
        if open.fetch_add(1, Ordering::SeqCst) >= MOST_CONNECTIONS {
            open.fetch_sub(1, Ordering::SeqCst);
            continue;
        }
        let (site, open) = (Arc::clone(&site), Arc::clone(&open));
        std::thread::spawn(move || {
            // Whoever has gone needs no answer.
            let _ = respond(stream, &site, own);
            open.fetch_sub(1, Ordering::SeqCst);
        });
    }
    Ok(())
}

fn respond(mut stream: TcpStream, site: &Site, own: SocketAddr) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut request = Vec::new();
    let mut buffer = [0; 2048];
    while !request.windows(4).any(|end| end == b"\r\n\r\n") {
        match stream.read(&mut buffer)? {
            0 => return Ok(()),
            n => request.extend_from_slice(&buffer[..n]),
        }
        if request.len() > LONGEST_REQUEST {
            break;
        }
    }
    let (answer, has_body) = answer(&String::from_utf8_lossy(&request), site, own);
    write!(
        stream,
        "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nX-Content-Type-Options: nosniff\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-store\r\n\
         Connection: close\r\n\r\n",
        answer.status,
        answer.kind,
        answer.body.len()
    )?;
    if has_body {
        stream.write_all(&answer.body)?;
    }
    stream.flush()
}

/// The answer to the head of a request, and whether its body is sent.
fn answer(request: &str, site: &Site, own: SocketAddr) -> (Answer, bool) {
    let mut lines = request.split("\r\n");
    let mut first = lines.next().unwrap_or_default().split(' ');
    let (method, target) = (first.next().unwrap_or_default(), first.next().unwrap_or_default());
    if method.is_empty()
        || !target.starts_with('/')
        || first.next().is_none_or(|version| !version.starts_with("HTTP/1."))
    {
        return (Answer::refusal("400 Bad Request"), true);
    }
    // A page from elsewhere whose name was made to lead here shows that name.
    let hosts: Vec<&str> = lines
        .filter_map(|line| line.split_once(':'))
        .filter(|(name, _)| name.eq_ignore_ascii_case("host"))
        .map(|(_, value)| value.trim())
        .collect();
    let known = [own.to_string(), format!("localhost:{}", own.port())];
    if !matches!(hosts[..], [host] if known.iter().any(|own| own == host)) {
        return (Answer::refusal("421 Misdirected Request"), true);
    }
    match method {
        "GET" => (file(target, site), true),
        "HEAD" => (file(target, site), false),
        _ => (Answer::refusal("405 Method Not Allowed"), true),
    }
}

/// What is at a target: the page at the root, or a file of a folder.
fn file(target: &str, site: &Site) -> Answer {
    let path = target.split('?').next().unwrap_or_default();
    if path == "/" {
        return Answer {
            status: "200 OK",
            kind: kind("index.html"),
            body: site.index.clone().into_bytes(),
        };
    }
    let missing = || Answer::refusal("404 Not Found");
    let Some((number, name)) = path[1..].split_once('/') else {
        return missing();
    };
    let index = number.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
    let Some(folder) = index.and_then(|index| site.folders.get(index)) else {
        return missing();
    };
    // Names of results have no other characters, so that none leads out of the folder or to what is hidden in it.
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
        return missing();
    }
    match read(&folder.join(name)) {
        Ok(body) => Answer {
            status: "200 OK",
            kind: kind(name),
            body,
        },
        Err(_) => missing(),
    }
}

/// The contents of a file that is no link to another.
fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    match std::fs::symlink_metadata(path)?.is_file() {
        true => std::fs::read(path),
        false => Err(std::io::ErrorKind::NotFound.into()),
    }
}

/// The type of a file by its ending.
fn kind(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("json") => "application/json",
        Some("csv") => "text/csv; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(request: &str) -> (Answer, bool) {
        let site = Site {
            index: "root".into(),
            folders: vec![Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()],
        };
        answer(request, &site, SocketAddr::from(([127, 0, 0, 1], 4711)))
    }

    fn status(request: &str) -> &'static str {
        ask(request).0.status
    }

    #[test]
    fn files_of_the_folders_are_served_and_nothing_else() {
        let get = |target: &str| status(&format!("GET {target} HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n\r\n"));
        for found in ["/", "/?a", "/1/Cargo.toml", "/1/README.md?x=/../y"] {
            assert_eq!(get(found), "200 OK", "{found}");
        }
        for missing in [
            "/1",
            "/1/",
            "/1/src",
            "/0/Cargo.toml",
            "/2/Cargo.toml",
            "/-1/Cargo.toml",
            "/1/../Cargo.toml",
            "/1/..",
            "/1/.",
            "/1//etc/passwd",
            "/1/src/lib.rs",
            "/1/..%2fCargo.toml",
            "/1/%2e%2e/Cargo.toml",
            "/1/..\\Cargo.toml",
            "/Cargo.toml",
            "//1/Cargo.toml",
            "/99999999999999999999999/Cargo.toml",
        ] {
            assert_eq!(get(missing), "404 Not Found", "{missing}");
        }
    }

    #[test]
    fn requests_for_other_hosts_and_with_other_methods_are_refused() {
        let with = |head: &str| status(&format!("GET / HTTP/1.1\r\n{head}\r\n"));
        assert_eq!(with("host: localhost:4711\r\n"), "200 OK");
        for head in [
            "",
            "Host: 127.0.0.1\r\n",
            "Host: example.org:4711\r\n",
            "Host: 127.0.0.1:4711.example.org\r\n",
            "Host: 127.0.0.1:4711\r\nHost: example.org\r\n",
        ] {
            assert_eq!(with(head), "421 Misdirected Request", "{head:?}");
        }
        let (head, has_body) = ask("HEAD / HTTP/1.1\r\nHost: localhost:4711\r\n\r\n");
        assert_eq!((head.body.len(), has_body), (4, false));
        let post = "POST / HTTP/1.1\r\nHost: localhost:4711\r\n\r\n";
        assert_eq!(status(post), "405 Method Not Allowed");
        for wrong in [
            "",
            "\r\n\r\n",
            "GET",
            "GET / FTP/1.1\r\n\r\n",
            "GET http://example.org/ HTTP/1.1\r\n\r\n",
        ] {
            assert_eq!(status(wrong), "400 Bad Request", "{wrong:?}");
        }
    }
}
