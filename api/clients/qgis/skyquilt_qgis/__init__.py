"""The Skyquilt plugin of QGIS: flights of a server as layers, uploads, photos of a place."""


def classFactory(iface):  # noqa: N802, the name that QGIS calls
    """What QGIS makes the plugin with."""
    from .plugin import SkyquiltPlugin
    return SkyquiltPlugin(iface)
