//! Access control: a token if the server is not on loopback, and no requests from pages of other origins.

use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, StatusCode};

/// Length of a random token, bytes.
const TOKEN: usize = 16;

/// The access rules of a server.
#[derive(Clone, Debug)]
pub struct Access {
    token: Option<String>,
    loopback: bool,
}

/// The status and reason of a refusal.
pub type Refusal = (StatusCode, &'static str);

impl Access {
    /// The rules for a server on loopback or on another address. Without `token`, a server on another address gets a
    /// random token.
    ///
    /// # Errors
    /// If the system provides no randomness.
    pub fn new(loopback: bool, token: Option<String>) -> Result<Self, getrandom::Error> {
        let token = match token {
            None if !loopback => {
                let mut bytes = [0; TOKEN];
                getrandom::fill(&mut bytes)?;
                Some(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
            }
            given => given,
        };
        Ok(Self { token, loopback })
    }

    /// The token, if one is required.
    #[must_use]
    pub fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }

    /// Whether a request with `headers` and the token `given` may be answered.
    ///
    /// # Errors
    /// The reason for the refusal.
    pub fn check(&self, headers: &HeaderMap, given: Option<&str>) -> Result<(), Refusal> {
        self.check_host(headers)?;
        let Some(token) = &self.token else { return Ok(()) };
        if given.is_some_and(|given| equal(given.as_bytes(), token.as_bytes())) {
            return Ok(());
        }
        Err((
            StatusCode::FORBIDDEN,
            "found no token or a wrong token, expected the one that hovernav ground printed",
        ))
    }

    /// Whether the request is meant for this server. This blocks requests that a page of another site makes through a
    /// browser.
    ///
    /// # Errors
    /// The reason for the refusal.
    pub fn check_host(&self, headers: &HeaderMap) -> Result<(), Refusal> {
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
        let host = text(HOST).unwrap_or_default();
        if self.loopback && self.token.is_none() {
            let name = host.rsplit_once(':').map_or(host, |(name, port)| {
                if port.bytes().all(|byte| byte.is_ascii_digit()) { name } else { host }
            });
            if !matches!(name, "localhost" | "127.0.0.1" | "[::1]") {
                return Err((
                    StatusCode::FORBIDDEN,
                    "found another host's name, expected localhost",
                ));
            }
        }
        if let Some(origin) = text(ORIGIN) {
            let own = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
            if own != Some(host) {
                return Err((
                    StatusCode::FORBIDDEN,
                    "found a page of another origin, expected a page of this server",
                ));
            }
        } else if headers.contains_key(ORIGIN) {
            return Err((StatusCode::FORBIDDEN, "found an origin that is not text"));
        }
        Ok(())
    }
}

/// Compares in constant time, so that the time does not reveal the position of a difference.
fn equal(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(ORIGIN, origin.parse().unwrap());
        }
        headers
    }

    #[test]
    fn on_loopback_only_loopback_is_answered() {
        let access = Access::new(true, None).unwrap();
        assert_eq!(access.token(), None);
        for host in ["localhost:8033", "127.0.0.1:8033", "[::1]:8033", "localhost"] {
            access.check(&headers(host, None), None).unwrap();
            access.check(&headers(host, Some(&format!("http://{host}"))), None).unwrap();
            access.check(&headers(host, Some("http://evil.example")), None).unwrap_err();
            access.check(&headers(host, Some("null")), None).unwrap_err();
        }
        for host in ["evil.example:8033", "127.0.0.1.evil.example", "", "localhost:x"] {
            access.check(&headers(host, None), None).unwrap_err();
        }
    }

    #[test]
    fn elsewhere_only_the_token_opens() {
        let access = Access::new(false, None).unwrap();
        let token = access.token().unwrap().to_owned();
        assert_eq!(token.len(), 2 * TOKEN);
        let asked = headers("192.168.1.7:8033", None);
        access.check(&asked, Some(&token)).unwrap();
        for wrong in
            [None, Some(""), Some("x"), Some(&token[1..]), Some(&token.to_uppercase()[..31])]
        {
            access.check(&asked, wrong).unwrap_err();
        }
        assert_ne!(Access::new(false, None).unwrap().token(), Some(token.as_str()));
    }
}
