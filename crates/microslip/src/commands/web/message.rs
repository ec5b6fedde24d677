//! Requests as they are understood, and answers to them.

use std::net::SocketAddr;
use std::path::Path;

pub(in crate::commands) const BAD_REQUEST: &str = "400 Bad Request";
pub(in crate::commands) const NOT_FOUND: &str = "404 Not Found";
pub(in crate::commands) const METHOD_NOT_ALLOWED: &str = "405 Method Not Allowed";

/// Largest body of a request that is read (bytes).
pub(in crate::commands) const LARGEST_BODY: u64 = 1 << 20;

/// What a request asks to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::commands) enum Method {
    /// To read something.
    Get,
    /// The same, without its body.
    Head,
    /// To do something with the body of the request.
    Post,
}

/// The head of a request that a page of this server can have sent, and its body.
#[derive(Debug)]
pub(in crate::commands) struct Request {
    pub(in crate::commands) method: Method,
    /// From the first slash on, without what follows a question mark.
    pub(in crate::commands) path: String,
    /// What follows it.
    pub(in crate::commands) query: String,
    /// Of a [`Method::Post`] alone.
    pub(in crate::commands) body: Vec<u8>,
    /// Length of the body, or the status of its refusal.
    pub(super) length: Result<u64, &'static str>,
}

/// An answer to a request.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::commands) struct Answer {
    pub(in crate::commands) status: &'static str,
    pub(in crate::commands) kind: &'static str,
    pub(in crate::commands) body: Vec<u8>,
    /// Content security policy, of a page that does not carry its own.
    pub(in crate::commands) policy: Option<String>,
}

impl Answer {
    /// Something that was found; `name` tells its kind.
    pub(in crate::commands) fn found(name: &str, body: impl Into<Vec<u8>>) -> Self {
        Self {
            status: "200 OK",
            kind: kind(name),
            body: body.into(),
            policy: None,
        }
    }

    /// A JSON document.
    pub(in crate::commands) fn json(document: &serde_json::Value) -> Self {
        Self::found("answer.json", document.to_string())
    }

    /// No more than a status.
    pub(in crate::commands) fn refusal(status: &'static str) -> Self {
        Self {
            status,
            kind: "text/plain; charset=utf-8",
            body: format!("{status}\n").into_bytes(),
            policy: None,
        }
    }
}

impl Request {
    /// Understands a head; what no page of the server at the address `own` can have sent is refused with a status.
    pub(super) fn of_head(head: &str, own: SocketAddr) -> Result<Self, &'static str> {
        let mut lines = head.split("\r\n");
        let mut first = lines.next().unwrap_or_default().split(' ');
        let (method, target) = (first.next().unwrap_or_default(), first.next().unwrap_or_default());
        if method.is_empty()
            || !target.starts_with('/')
            || first.next().is_none_or(|version| !version.starts_with("HTTP/1."))
        {
            return Err(BAD_REQUEST);
        }
        let fields: Vec<(&str, &str)> = lines
            .filter_map(|line| line.split_once(':'))
            .map(|(name, value)| (name, value.trim()))
            .collect();
        let values = |wanted: &str| -> Vec<&str> {
            let of = fields.iter().filter(|(name, _)| name.eq_ignore_ascii_case(wanted));
            of.map(|(_, value)| *value).collect()
        };
        // A page from elsewhere whose name was made to lead here shows that name.
        let known = [own.to_string(), format!("localhost:{}", own.port())];
        if !matches!(values("host")[..], [host] if known.iter().any(|own| own == host)) {
            return Err("421 Misdirected Request");
        }
        let method = match method {
            "GET" => Method::Get,
            "HEAD" => Method::Head,
            "POST" => Method::Post,
            _ => return Err(METHOD_NOT_ALLOWED),
        };
        let length = match method {
            Method::Get | Method::Head => Ok(0),
            Method::Post => length_of_body(values, &known),
        };
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        Ok(Self {
            method,
            path: path.to_owned(),
            query: query.to_owned(),
            body: Vec::new(),
            length,
        })
    }
}

/// Length of a body that a page of one of the `known` hosts sends; `values` are those of a field of the head.
fn length_of_body<'a>(values: impl Fn(&str) -> Vec<&'a str>, known: &[String]) -> Result<u64, &'static str> {
    let is_own = |origin: &str| {
        let host = origin.strip_prefix("http://");
        host.is_some_and(|host| known.iter().any(|own| own == host))
    };
    // A page from elsewhere can send a form here, with its own origin, and no JSON.
    if !matches!(values("origin")[..], [origin] if is_own(origin)) {
        return Err("403 Forbidden");
    }
    if values("content-type") != ["application/json"] {
        return Err("415 Unsupported Media Type");
    }
    if !values("transfer-encoding").is_empty() {
        return Err("411 Length Required");
    }
    match values("content-length")[..] {
        [] => Err("411 Length Required"),
        [digits] if digits.bytes().all(|digit| digit.is_ascii_digit()) => match digits.parse() {
            Ok(length) if length <= LARGEST_BODY => Ok(length),
            _ => Err("413 Content Too Large"),
        },
        _ => Err(BAD_REQUEST),
    }
}

/// The file of this name in a folder. Names of results have no other characters than those admitted here, so that none leads out of the folder or
/// to what is hidden in it.
pub(in crate::commands) fn file(folder: &Path, name: &str) -> Answer {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
        return Answer::refusal(NOT_FOUND);
    }
    match read(&folder.join(name)) {
        Ok(body) => Answer::found(name, body),
        Err(_) => Answer::refusal(NOT_FOUND),
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

    fn own() -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], 4711))
    }

    fn refused(head: &str) -> Option<&'static str> {
        Request::of_head(head, own()).err()
    }

    #[test]
    fn requests_for_other_hosts_and_with_other_methods_are_refused() {
        let with = |head: &str| refused(&format!("GET / HTTP/1.1\r\n{head}\r\n"));
        assert_eq!(with("host: localhost:4711\r\n"), None);
        for head in [
            "",
            "Host: 127.0.0.1\r\n",
            "Host: example.org:4711\r\n",
            "Host: 127.0.0.1:4711.example.org\r\n",
            "Host: 127.0.0.1:4711\r\nHost: example.org\r\n",
        ] {
            assert_eq!(with(head), Some("421 Misdirected Request"), "{head:?}");
        }
        for method in ["PUT", "DELETE", "OPTIONS", "TRACE", "get"] {
            let head = format!("{method} / HTTP/1.1\r\nHost: localhost:4711\r\n\r\n");
            assert_eq!(refused(&head), Some(METHOD_NOT_ALLOWED), "{method}");
        }
        for wrong in [
            "",
            "\r\n\r\n",
            "GET",
            "GET / FTP/1.1\r\n\r\n",
            "GET http://example.org/ HTTP/1.1\r\n\r\n",
        ] {
            assert_eq!(refused(wrong), Some(BAD_REQUEST), "{wrong:?}");
        }
    }

    #[test]
    fn only_own_pages_can_send_bodies() {
        let post = |head: &str| {
            let head = format!("POST /a HTTP/1.1\r\nHost: localhost:4711\r\n{head}\r\n");
            Request::of_head(&head, own()).unwrap().length
        };
        let json = "Content-Type: application/json\r\n";
        let origin = "Origin: http://127.0.0.1:4711\r\n";
        let length = "Content-Length: 2\r\n";
        assert_eq!(post(&format!("{json}{origin}{length}")), Ok(2));
        for foreign in [
            "",
            "Origin: null\r\n",
            "Origin: http://example.org\r\n",
            "Origin: https://127.0.0.1:4711\r\n",
            "Origin: http://127.0.0.1:4712\r\n",
            "Origin: http://127.0.0.1:4711\r\nOrigin: http://example.org\r\n",
        ] {
            assert_eq!(
                post(&format!("{json}{foreign}{length}")),
                Err("403 Forbidden"),
                "{foreign}"
            );
        }
        for kind in [
            "",
            "Content-Type: text/plain\r\n",
            "Content-Type: application/json; a=b\r\n",
        ] {
            let status = post(&format!("{kind}{origin}{length}"));
            assert_eq!(status, Err("415 Unsupported Media Type"), "{kind}");
        }
        for (wrong, status) in [
            ("", "411 Length Required"),
            ("Transfer-Encoding: chunked\r\n", "411 Length Required"),
            (
                "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n",
                "411 Length Required",
            ),
            ("Content-Length: -2\r\n", BAD_REQUEST),
            ("Content-Length: +2\r\n", BAD_REQUEST),
            ("Content-Length: 2\r\nContent-Length: 2\r\n", BAD_REQUEST),
            ("Content-Length: 1048577\r\n", "413 Content Too Large"),
            ("Content-Length: 99999999999999999999\r\n", "413 Content Too Large"),
        ] {
            assert_eq!(post(&format!("{json}{origin}{wrong}")), Err(status), "{wrong}");
        }
    }

    #[test]
    fn names_lead_nowhere_else() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert_eq!(file(folder, "Cargo.toml").status, "200 OK");
        for name in [
            "",
            ".",
            "..",
            "src",
            "src/lib.rs",
            "../Cargo.toml",
            "..%2fCargo.toml",
            "..\\Cargo.toml",
            "/etc/passwd",
        ] {
            assert_eq!(file(folder, name).status, NOT_FOUND, "{name}");
        }
    }
}
