//! Addresses: which are asked, where a redirect leads, what the file is called.
//!
//! Only http and https. A redirect is resolved against the address that answered with it (RFC 3986, section
//! 5.2, without dot segments: a server that wants those removed can send them removed); it never leads from
//! https to http.

use super::error::FetchError;
use ureq::http::Uri;

/// A complete http or https address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Address(Uri);

impl Address {
    /// # Errors
    /// [`FetchError::Address`] for anything else.
    pub fn parse(url: &str) -> Result<Self, FetchError> {
        let fail = |reason: &str| FetchError::Address { url: url.into(), reason: reason.into() };
        let uri: Uri = url.parse().map_err(|e| fail(&format!("no address ({e})")))?;
        match uri.scheme_str() {
            Some("http" | "https") => {}
            Some(other) => return Err(fail(&format!("`{other}` is not asked"))),
            None => return Err(fail("no http:// or https:// at its start")),
        }
        match uri.host() {
            Some(host) if !host.is_empty() => Ok(Self(uri)),
            _ => Err(fail("no host")),
        }
    }

    /// The text.
    pub fn text(&self) -> String {
        self.0.to_string()
    }

    /// For the request.
    pub fn uri(&self) -> &Uri {
        &self.0
    }

    /// Whether it is this machine, which no proxy should be asked for.
    pub fn is_local(&self) -> bool {
        let host = self.0.host().unwrap_or_default();
        let ip = host.trim_matches(['[', ']']).parse::<std::net::IpAddr>();
        host == "localhost" || ip.is_ok_and(|ip| ip.is_loopback())
    }

    /// The last part of the path; empty when the path ends with `/`.
    pub fn file_name(&self) -> &str {
        self.0.path().rsplit('/').next().unwrap_or_default()
    }

    /// The address that a `Location` header gives.
    ///
    /// # Errors
    /// [`FetchError::Redirect`] when it is not to be followed.
    pub fn redirected(&self, location: &str) -> Result<Self, FetchError> {
        let refuse = |reason| FetchError::Redirect { url: self.text(), to: location.into(), reason };
        let scheme = self.0.scheme_str().unwrap_or_default();
        let authority = self.0.authority().map_or("", |a| a.as_str());
        let location = location.split('#').next().unwrap_or_default();
        let folder = self.0.path().rsplit_once('/').map_or("", |(folder, _)| folder);
        let full = match location {
            "" => return Err(refuse("nowhere")),
            l if has_scheme(l) => l.to_owned(),
            l if l.starts_with("//") => format!("{scheme}:{l}"),
            l if l.starts_with('/') => format!("{scheme}://{authority}{l}"),
            l if l.starts_with('?') => format!("{scheme}://{authority}{}{l}", self.0.path()),
            l => format!("{scheme}://{authority}{folder}/{l}"),
        };
        let to = Self::parse(&full).map_err(|_| refuse("which is no http or https address"))?;
        if scheme == "https" && to.0.scheme_str() != Some("https") {
            return Err(refuse("away from https"));
        }
        Ok(to)
    }
}

/// Whether a reference starts with a scheme (RFC 3986, section 3.1).
fn has_scheme(reference: &str) -> bool {
    let Some((scheme, _)) = reference.split_once(':') else { return false };
    scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
}

/// The address of an archive, at a mirror if there is one: its file name below the mirror's prefix.
///
/// # Errors
/// [`FetchError::Address`].
pub(super) fn of_archive(url: &str, mirror: Option<&str>) -> Result<Address, FetchError> {
    let original = Address::parse(url)?;
    match mirror {
        None => Ok(original),
        Some(prefix) => Address::parse(&format!("{}/{}", prefix.trim_end_matches('/'), original.file_name())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_complete_http_addresses() {
        for bad in
            ["", "x", "/a.zip", "file:///etc/passwd", "ftp://h/a", "http://", "http:///a", "HT TP://h/"]
        {
            assert!(matches!(Address::parse(bad), Err(FetchError::Address { .. })), "{bad}");
        }
        let address = Address::parse("http://h:81/a/b.zip?x=1").unwrap();
        assert_eq!((address.file_name(), address.is_local()), ("b.zip", false));
        for local in ["http://127.0.0.1:9/", "http://[::1]:9/", "http://localhost/"] {
            assert!(Address::parse(local).unwrap().is_local(), "{local}");
        }
    }

    // Python: urllib.parse.urljoin('https://h:81/a/b.zip?q=1', location)
    #[test]
    fn redirects_are_resolved() {
        let base = Address::parse("https://h:81/a/b.zip?q=1").unwrap();
        for (location, wanted) in [
            ("https://x/y", "https://x/y"),
            ("//x/y", "https://x/y"),
            ("/y", "https://h:81/y"),
            ("y", "https://h:81/a/y"),
            ("?z", "https://h:81/a/b.zip?z"),
            ("y#part", "https://h:81/a/y"),
        ] {
            assert_eq!(base.redirected(location).unwrap().text(), wanted, "{location}");
        }
        for bad in
            ["", "#x", "http://h/a", "file:///etc/passwd", "ftp://h/a", "javascript:x", "https://", "a b"]
        {
            assert!(matches!(base.redirected(bad), Err(FetchError::Redirect { .. })), "{bad}");
        }
        let plain = Address::parse("http://h/a").unwrap();
        assert_eq!(plain.redirected("https://h/a").unwrap().text(), "https://h/a");
    }

    #[test]
    fn a_mirror_has_the_file_below_its_prefix() {
        let url = "http://h/seq/David.zip";
        assert_eq!(of_archive(url, None).unwrap().text(), url);
        for prefix in ["https://m/otb", "https://m/otb/"] {
            assert_eq!(of_archive(url, Some(prefix)).unwrap().text(), "https://m/otb/David.zip");
        }
        assert!(of_archive(url, Some("/srv/otb")).is_err());
    }
}
