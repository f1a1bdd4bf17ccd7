"""Which server is asked, and with which token. The address is in QGIS' settings; the token is in QGIS' store of secrets
(which asks for its master password), or in memory until QGIS ends: never in a file that can be read."""
from qgis.core import QgsApplication, QgsSettings

from .skyquilt import Client

URL_KEY = "skyquilt/url"
KEPT_KEY = "skyquilt/token_is_kept"
DEFAULT_URL = "http://127.0.0.1:8080"
_tokens = {}  # url: token, of this session


def _secret_key(url):
    return f"skyquilt/token/{url}"


def url():
    """The address of the server."""
    return QgsSettings().value(URL_KEY, DEFAULT_URL)


def token():
    """The token for it, or None. May ask for QGIS' master password, once."""
    address = url()
    if address not in _tokens and QgsSettings().value(KEPT_KEY, False, type=bool):
        _tokens[address] = QgsApplication.authManager().authSetting(_secret_key(address), "", True) or None
    return _tokens.get(address)


def is_token_kept():
    """Whether the token outlives this session."""
    return QgsSettings().value(KEPT_KEY, False, type=bool)


def keep(new_url, new_token, keeps_token):
    """Takes over what the user typed. Raises InputError for an address that is none. Returns whether the token could be kept as
    was wished: not where the master password was not given."""
    client = Client(new_url, new_token or None)
    manager = QgsApplication.authManager()
    if is_token_kept() and manager.existsAuthSetting(_secret_key(url())):
        manager.removeAuthSetting(_secret_key(url()))
    is_kept = bool(keeps_token and new_token) and manager.storeAuthSetting(_secret_key(client.url), new_token, True)
    settings = QgsSettings()
    settings.setValue(URL_KEY, client.url)
    settings.setValue(KEPT_KEY, is_kept)
    _tokens.clear()
    _tokens[client.url] = new_token or None
    return is_kept or not (keeps_token and new_token)


def connect():
    """A client of the server. Raises InputError."""
    return Client(url(), token())
