//! Pages in a browser on the same computer: a small server on the loopback interface.

mod message;
mod server;

pub(super) use message::{Answer, BAD_REQUEST, METHOD_NOT_ALLOWED, Method, NOT_FOUND, Request, file};
pub(super) use server::{Site, serve};

use anyhow::{Context, Result};
use std::net::{Ipv4Addr, TcpListener};
use std::process::{Command, Stdio};

/// A listener on the loopback interface, at a port that is free where it is 0, and its address as a browser has it.
pub(super) fn listen(port: u16) -> Result<(TcpListener, String)> {
    let listening = || format!("listening on the loopback interface, port {port}");
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(listening)?;
    let address = format!("http://{}/", listener.local_addr().with_context(listening)?);
    Ok((listener, address))
}

/// Asks the system to show an address. Where it cannot, the reader has the address.
pub(super) fn open(address: &str) {
    let (program, arguments) = if cfg!(target_os = "macos") {
        ("open", vec![address])
    } else if cfg!(windows) {
        ("rundll32", vec!["url.dll,FileProtocolHandler", address])
    } else {
        ("xdg-open", vec![address])
    };
    let mut command = Command::new(program);
    let command = command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if let Ok(mut child) = command.spawn() {
        std::thread::spawn(move || child.wait());
    }
}
