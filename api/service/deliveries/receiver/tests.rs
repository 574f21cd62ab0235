//! What a message's way out refuses, with receivers that run here.

use super::*;
use clap::Parser;
use parking_lot::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;

#[derive(Debug, Parser)]
struct Flags {
    #[command(flatten)]
    settings: DeliverySettings,
    // `--webhook-secret-file` conflicts with it.
    #[arg(long)]
    keys: Option<String>,
}

fn settings(flags: &[&str]) -> DeliverySettings {
    Flags::parse_from([&["strahl"], flags].concat()).settings
}

fn secret() -> Secret {
    Secret::of(&[1; 32])
}

/// A receiver that answers every request in the same way; the requests that it has seen.
async fn receiver(answer: impl Into<Vec<u8>>) -> (u16, Arc<Mutex<Vec<String>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (port, seen, answer) =
        (listener.local_addr().unwrap().port(), Arc::<Mutex<Vec<String>>>::default(), answer.into());
    let requests = Arc::clone(&seen);
    tokio::spawn(async move {
        while let Ok((mut socket, _)) = listener.accept().await {
            let (requests, answer) = (Arc::clone(&requests), answer.clone());
            tokio::spawn(async move {
                let mut request = Vec::new();
                while !request.ends_with(b"{}") {
                    let mut bytes = [0; 4_096];
                    match socket.read(&mut bytes).await {
                        Ok(0) | Err(_) => return,
                        Ok(read) => request.extend(&bytes[..read]),
                    }
                }
                requests.lock().push(String::from_utf8(request).unwrap());
                let _ = socket.write_all(&answer).await;
                if answer.is_empty() {
                    tokio::time::sleep(Duration::from_secs(60)).await;
                }
            });
        }
    });
    (port, seen)
}

async fn send(receivers: &Receivers, url: &str) -> Result<(), Refusal> {
    receivers.send(url, &Message { id: "msg_1", body: "{}", secret: &secret() }).await
}

fn why(refused: Result<(), Refusal>) -> String {
    match refused {
        Ok(()) => panic!("it arrived"),
        Err(Refusal::Later(why, _) | Refusal::Never(why)) => why,
    }
}

const LOCAL: [&str; 3] = ["--webhook-http", "--webhook-allow", "127.0.0.0/8"];

#[tokio::test]
async fn a_message_arrives_signed() {
    let (port, seen) = receiver("HTTP/1.1 204 No Content\r\n\r\n").await;
    let receivers = Receivers::new(&settings(&LOCAL));
    send(&receivers, &format!("http://127.0.0.1:{port}/hook?a=b")).await.unwrap();
    send(&receivers, &format!("http://localhost:{port}/hook")).await.unwrap();
    let seen = seen.lock();
    assert!(seen[0].starts_with("POST /hook?a=b HTTP/1.1\r\n"), "{}", seen[0]);
    let header = |name: &str| {
        let line = seen[0].lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        line.unwrap_or_else(|| panic!("{name} in {}", seen[0])).to_owned()
    };
    assert_eq!(header("webhook-id"), "msg_1");
    assert_eq!(header("content-type"), "application/json");
    let seconds = header("webhook-timestamp").parse().unwrap();
    assert!(unix_time().as_secs() - seconds < 60);
    assert_eq!(header("webhook-signature"), secret().sign("msg_1", seconds, "{}"));
}

#[tokio::test]
async fn a_receiver_says_when_to_send_again() {
    let receivers = Receivers::new(&settings(&LOCAL));
    let date = |seconds| httpdate::fmt_http_date(SystemTime::now() + Duration::from_secs(seconds));
    for (status, value, seconds) in [
        ("503 Busy", "60".to_owned(), 59..61),
        ("503 Busy", date(600), 540..601),
        ("307 Elsewhere", "60".to_owned(), 59..61),
        ("503 Busy", date(0), 0..1),
        ("503 Busy", "soon".to_owned(), 0..1),
        ("503 Busy", date(100_000), 3_600..3_601),
    ] {
        let answer = format!("HTTP/1.1 {status}\r\nRetry-After: {value}\r\nContent-Length: 0\r\n\r\n");
        let (port, _) = receiver(answer).await;
        match send(&receivers, &format!("http://127.0.0.1:{port}/")).await {
            Err(Refusal::Later(_, wait)) => assert!(seconds.contains(&wait.as_secs()), "{value}: {wait:?}"),
            other => panic!("{value}: {other:?}"),
        }
    }
}

#[tokio::test]
async fn what_is_inside_is_not_reached_by_any_name() {
    let (port, seen) = receiver("HTTP/1.1 204 No Content\r\n\r\n").await;
    let receivers = Receivers::new(&settings(&["--webhook-http"]));
    for host in [
        "127.0.0.1",
        "localhost",
        "[::1]",
        "[::ffff:127.0.0.1]",
        "0.0.0.0",
        "[::]",
        "2130706433",
        "0x7f000001",
        "0177.0.0.1",
        "127.1",
        "169.254.169.254",
        "[fd00:ec2::254]",
        "[64:ff9b::7f00:1]",
    ] {
        let refused = why(send(&receivers, &format!("http://{host}:{port}/")).await);
        assert!(refused.contains("not public"), "{host}: {refused}");
    }
    assert_eq!(seen.lock().len(), 0);
}

#[tokio::test]
async fn urls_that_are_none_of_a_webhook_are_refused() {
    let rules = Rules::of(&settings(&[]));
    for (url, part) in [
        ("http://example.org/", "--webhook-http"),
        ("ftp://example.org/", "not ftp://"),
        ("file:///etc/passwd", "not file://"),
        ("https://user:password@example.org/", "no user and password"),
        ("https://", "cannot be read"),
        ("hook", "cannot be read"),
        (&format!("https://example.org/{}", "a".repeat(2_048)), "at most"),
        ("https://10.0.0.1/", "not public"),
    ] {
        let refused = rules.check(url).unwrap_err();
        assert!(refused.contains(part), "{url}: {refused}");
    }
    assert!(rules.check("https://hooks.example.org:8443/a?b=c").is_ok());
}

/// A name that is public when it is looked up first, and this machine the next time.
#[tokio::test]
async fn the_address_that_was_checked_is_the_one_that_is_connected_to() {
    let (port, seen) = receiver("HTTP/1.1 204 No Content\r\n\r\n").await;
    let lookups = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&lookups);
    // 192.0.2.1 is nobody's; it stands for a public address here.
    let rebinding = move |_: String| -> BoxFuture<'static, io::Result<Vec<IpAddr>>> {
        let address: &str = if count.fetch_add(1, Ordering::SeqCst) == 0 { "192.0.2.1" } else { "127.0.0.1" };
        Box::pin(async move { Ok(vec![address.parse().unwrap()]) })
    };
    let flags = ["--webhook-http", "--webhook-allow", "192.0.2.0/24", "--webhook-timeout", "0.3"];
    let receivers = Receivers::with(&settings(&flags), Arc::new(rebinding));
    let url = format!("http://rebind.example:{port}/");
    let first = why(send(&receivers, &url).await);
    assert!(!first.contains("not public"), "the first address is tried: {first}");
    assert_eq!(lookups.load(Ordering::SeqCst), 1, "the connection takes no other lookup");
    let second = why(send(&receivers, &url).await);
    assert!(second.contains("not public"), "{second}");
    assert_eq!(seen.lock().len(), 0);
}

#[tokio::test]
async fn of_several_addresses_only_those_that_may_be_are_tried() {
    let (port, seen) = receiver("HTTP/1.1 204 No Content\r\n\r\n").await;
    let mixed = |_: String| -> BoxFuture<'static, io::Result<Vec<IpAddr>>> {
        Box::pin(async { Ok(["127.0.0.2", "127.0.0.1"].map(|address| address.parse().unwrap()).to_vec()) })
    };
    let flags = ["--webhook-http", "--webhook-allow", "127.0.0.1"];
    let receivers = Receivers::with(&settings(&flags), Arc::new(mixed));
    send(&receivers, &format!("http://mixed.example:{port}/")).await.unwrap();
    assert_eq!(seen.lock().len(), 1);
}

#[tokio::test]
async fn redirects_are_not_followed() {
    let (inner, reached) = receiver("HTTP/1.1 204 No Content\r\n\r\n").await;
    let location =
        format!("HTTP/1.1 307 Temporary Redirect\r\nLocation: http://127.0.0.1:{inner}/\r\nContent-Length: 0\r\n\r\n");
    let (port, _) = receiver(location).await;
    let receivers = Receivers::new(&settings(&LOCAL));
    let refused = why(send(&receivers, &format!("http://127.0.0.1:{port}/")).await);
    assert!(refused.contains("redirects are not followed"), "{refused}");
    assert_eq!(reached.lock().len(), 0);
}

#[tokio::test]
async fn answers_decide_whether_it_is_tried_again() {
    let receivers = Receivers::new(&settings(&LOCAL));
    let of = async |answer: &str| {
        let (port, _) = receiver(format!("HTTP/1.1 {answer}\r\nContent-Length: 0\r\n\r\n")).await;
        send(&receivers, &format!("http://127.0.0.1:{port}/")).await
    };
    assert_eq!(of("200 OK").await, Ok(()));
    assert_eq!(of("202 Accepted").await, Ok(()));
    assert!(matches!(of("410 Gone").await, Err(Refusal::Never(_))));
    assert!(matches!(of("500 Oops").await, Err(Refusal::Later(why, Duration::ZERO)) if why.contains("500")));
    let asked = of("503 Busy\r\nRetry-After: 7").await;
    assert!(matches!(asked, Err(Refusal::Later(_, wait)) if wait == Duration::from_secs(7)));
    let asked = of("429 Slow\r\nRetry-After: 99999999").await;
    assert!(matches!(asked, Err(Refusal::Later(_, wait)) if wait == Duration::from_secs(3_600)));
    let closed = TcpListener::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap().port();
    assert!(matches!(send(&receivers, &format!("http://127.0.0.1:{closed}/")).await, Err(Refusal::Later(..))));
}

#[tokio::test]
async fn slow_and_endless_answers_end() {
    let flags = [&LOCAL[..], &["--webhook-timeout", "0.5"]].concat();
    let receivers = Receivers::new(&settings(&flags));
    let (silent, _) = receiver("").await;
    let refused = why(send(&receivers, &format!("http://127.0.0.1:{silent}/")).await);
    assert!(refused.contains("in time"), "{refused}");

    // A gigabyte is promised, of which 8 MiB would come.
    let receivers = Receivers::new(&settings(&LOCAL));
    let endless = [&b"HTTP/1.1 200 OK\r\nContent-Length: 1000000000\r\n\r\n"[..], &vec![b'x'; 8 << 20]].concat();
    let (huge, _) = receiver(endless).await;
    send(&receivers, &format!("http://127.0.0.1:{huge}/")).await.unwrap();
}
