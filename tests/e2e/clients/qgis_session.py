"""QGIS without a screen, with the plugin loaded as QGIS loads it: qgis_session.py PLUGINS URL OUT < STEPS. STEPS is a list of
[step, arguments ...]; what each gave is printed as one JSON list. Run by qgis_plugin_test.py."""
import json
import os
import pathlib
import sys
import time

PLUGINS, URL, OUT = sys.argv[1:4]
os.environ["QT_QPA_PLATFORM"] = "offscreen"
os.environ["QGIS_CUSTOM_CONFIG_PATH"] = os.environ["XDG_RUNTIME_DIR"] = OUT

import qgis.utils  # noqa: E402
from qgis.core import (QgsApplication, QgsCoordinateReferenceSystem, QgsCoordinateTransform, QgsMapRendererParallelJob,  # noqa: E402
                       QgsPointXY, QgsProject, QgsRectangle, QgsSettings)
from qgis.gui import QgsLayerTreeMapCanvasBridge, QgsMapCanvas, QgsMessageBar  # noqa: E402
from qgis.PyQt.QtCore import QObject, QSize, Qt  # noqa: E402
from qgis.PyQt.QtWidgets import QMainWindow  # noqa: E402

PATIENCE_S = 240


class Interface(QObject):
    """What of QGIS' window the plugin asks for, of real parts."""

    def __init__(self):
        super().__init__()
        self.window, self.actions = QMainWindow(), []
        self.canvas = QgsMapCanvas(self.window)
        self.canvas.setDestinationCrs(QgsCoordinateReferenceSystem("EPSG:3857"))
        self.bridge = QgsLayerTreeMapCanvasBridge(QgsProject.instance().layerTreeRoot(), self.canvas)
        self.bar, self.said = QgsMessageBar(self.window), []
        self.bar.widgetAdded.connect(lambda _: self.said.append(self.bar.currentItem().text()))
        self.window.setCentralWidget(self.canvas)
        self.tools = self.window.addToolBar("Web")
        self.menu = self.window.menuBar().addMenu("Web")
        self.window.resize(1300, 860)

    def mainWindow(self):
        return self.window

    def mapCanvas(self):
        return self.canvas

    def messageBar(self):
        return self.bar

    def addDockWidget(self, area, dock):
        self.window.addDockWidget(area, dock)
        self.window.resizeDocks([dock], [430], Qt.Horizontal)

    def removeDockWidget(self, dock):
        self.window.removeDockWidget(dock)

    def addToolBarIcon(self, action):
        self.tools.addAction(action)

    def removeToolBarIcon(self, action):
        self.tools.removeAction(action)

    def addPluginToWebMenu(self, _, action):
        self.menu.addAction(action)

    def removePluginWebMenu(self, _, action):
        self.menu.removeAction(action)


class Session:
    """The steps, by name."""

    def __init__(self):
        self.application = QgsApplication([], True)
        self.application.initQgis()
        QgsSettings().setValue("skyquilt/url", URL)
        self.iface = Interface()
        self.layers = QgsProject.instance().mapLayers
        qgis.utils.initInterface = None
        qgis.utils.iface = self.iface
        qgis.utils.plugin_paths = [PLUGINS]
        sys.path.insert(0, PLUGINS)
        qgis.utils.updateAvailablePlugins()
        assert qgis.utils.loadPlugin("skyquilt_qgis") and qgis.utils.startPlugin("skyquilt_qgis"), qgis.utils.plugins
        self.plugin = qgis.utils.plugins["skyquilt_qgis"]
        self.dock = self.plugin.dock
        self.iface.window.show()
        self.until(lambda: not self.plugin.is_refreshing)

    def until(self, condition):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, (self.iface.said, self.dock.said.text())
            self.application.processEvents()
            time.sleep(0.01)

    def rows(self):
        """What the list shows."""
        shown = (self.dock.flights.topLevelItem(row) for row in range(self.dock.flights.topLevelItemCount()))
        return [[item.text(column) for column in range(4)] for item in shown]

    def said(self):
        """What the panel and the message bar said."""
        return [self.dock.said.text(), *self.iface.said]

    def choose(self, flight_id):
        """Whether its map can be added."""
        self.dock.choose(flight_id)
        return self.dock.add.isEnabled()

    def token(self, token, is_kept):
        """By the settings dialog: whether it closed, what it said, whether the token is in any file of QGIS."""
        from skyquilt_qgis import servers
        from skyquilt_qgis.settings_dialog import SettingsDialog
        QgsApplication.authManager().setMasterPassword("of the test", True)
        dialog = SettingsDialog(self.iface.window)
        dialog.token.setText(token)
        dialog.keeps.setChecked(is_kept)
        dialog.accept()
        servers._tokens.clear()  # as after a start of QGIS
        kept = servers.token()
        servers._tokens[servers.url()] = token
        QgsSettings().sync()
        contents = [pathlib.Path(folder, name).read_bytes() for folder, _, names in os.walk(OUT) for name in names]
        self.refresh()
        return [dialog.result() == 1, kept, any(token.encode() in content for content in contents)]

    def refresh(self):
        """Asks for the list."""
        self.plugin.refresh()
        self.until(lambda: not self.plugin.is_refreshing)

    def add(self, kind):
        """The chosen flight as a layer: its provider, source and whether it is valid."""
        before, said = set(self.layers()), len(self.iface.said)
        self.dock.layer_wanted.emit(kind)
        self.until(lambda: set(self.layers()) - before or len(self.iface.said) > said)
        [layer] = [self.layers()[name] for name in set(self.layers()) - before]
        self.shown = layer
        return [layer.providerType(), layer.source(), layer.isValid(), getattr(layer, "featureCount", int)()]

    def forget(self, instead):
        """The tokens of links: as after a start of QGIS with None, else as where this one was revoked."""
        self.plugin.reading_tokens = {} if instead is None else dict.fromkeys(self.plugin.reading_tokens, instead)

    def ask(self, kind):
        """For the chosen flight as a layer that it does not have: until it is said so."""
        said = len(self.iface.said)
        self.dock.layer_wanted.emit(kind)
        self.until(lambda: len(self.iface.said) > said)

    def render(self, name, west, south, east, north, side):
        """The last layer on the canvas, in Web Mercator, as a picture."""
        settings = self.iface.canvas.mapSettings()
        settings.setLayers([self.shown])
        settings.setOutputSize(QSize(side, side))
        settings.setExtent(QgsRectangle(west, south, east, north))
        settings.setOutputDpi(96)
        job = QgsMapRendererParallelJob(settings)
        job.start()
        job.waitForFinished()
        job.renderedImage().save(os.path.join(OUT, name))

    def zoom(self):
        """"Zoom to Layer" of the last one; what the canvas shows then, in degrees."""
        settings = self.iface.canvas.mapSettings()
        self.iface.canvas.setExtent(settings.layerExtentToOutputExtent(self.shown, self.shown.extent()))
        return self.extent()

    def extent(self):
        """What the canvas shows, in degrees, once nothing is on its way."""
        self.settle()
        to_degrees = QgsCoordinateTransform(self.iface.canvas.mapSettings().destinationCrs(), QgsCoordinateReferenceSystem("EPSG:4326"),
                                            QgsProject.instance())
        box = to_degrees.transformBoundingBox(self.iface.canvas.extent())
        return [box.xMinimum(), box.yMinimum(), box.xMaximum(), box.yMaximum()]

    def view(self):
        """What the canvas shows, in its own coordinates."""
        self.settle()
        box = self.iface.canvas.extent()
        return [box.xMinimum(), box.yMinimum(), box.xMaximum(), box.yMaximum()]

    def click(self, lon, lat):
        """With the tool of the panel, on the canvas: names of the photos, and where the cross is in the picture (0 to 1)."""
        self.dock.place.click()
        assert self.iface.canvas.mapTool() is self.plugin.place_tool
        from_degrees = QgsCoordinateTransform(QgsCoordinateReferenceSystem("EPSG:4326"), self.iface.canvas.mapSettings().destinationCrs(),
                                              QgsProject.instance())
        panel = self.dock.photos
        panel.title.setText("")
        self.plugin.place_tool.canvasClicked.emit(from_degrees.transform(QgsPointXY(lon, lat)), Qt.LeftButton)
        self.until(lambda: panel.title.text())
        if panel.list.count():
            self.until(lambda: not panel.view._image.isNull() or "cannot" in panel.view.text())
        photos = [panel.list.item(row).data(Qt.UserRole)[1] for row in range(panel.list.count())]
        image, at = panel.view._image, panel.view._at
        self.dock.place.click()
        assert self.iface.canvas.mapTool() is not self.plugin.place_tool
        return [panel.title.text(), photos, [image.width(), image.height(), at.x(), at.y()]]

    def upload(self, folder, name):
        """Until the map is there: the stages that were told."""
        self.plugin.upload(folder, name)
        stages = set()

        def has_ended():
            if self.plugin.upload_work is not None and self.plugin.upload_work.last is not None:
                stages.add(self.plugin.upload_work.last.stage)
            return self.plugin.upload_work is None and self.iface.said
        self.until(has_ended)
        self.until(lambda: self.dock.chosen() is not None)
        return sorted(stages)

    def upload_and_cancel(self, folder, name):
        """Stopped at its first progress."""
        self.plugin.upload(folder, name)
        self.until(lambda: self.plugin.upload_work.last is not None)
        self.plugin.show_upload()
        self.grab("uploading.png")
        self.dock.cancel_wanted.emit()
        self.until(lambda: self.plugin.upload_work is None and not self.plugin.is_refreshing)
        return self.dock.bar.isVisible()

    def settle(self):
        """Lets the window do what it has put off."""
        for _ in range(50):
            self.application.processEvents()
            time.sleep(0.01)
        self.until(lambda: not self.iface.canvas.isDrawing())

    def go(self):
        """From elsewhere to the chosen flight."""
        self.iface.canvas.setExtent(QgsRectangle(0, 0, 1, 1))
        self.dock.place_wanted.emit()
        return self.extent()

    def grab(self, name):
        """The whole window as a picture."""
        self.settle()
        self.iface.window.grab().save(os.path.join(OUT, name))

    def unload(self):
        """What is left in the window."""
        unloaded = qgis.utils.unloadPlugin("skyquilt_qgis")
        self.application.processEvents()
        return [bool(unloaded), len(self.iface.tools.actions()), len(self.iface.menu.actions())]


def main():
    session = Session()
    print(json.dumps([getattr(session, step)(*arguments) for step, *arguments in json.load(sys.stdin)]))
    sys.stdout.flush()
    os._exit(0)  # QGIS' own end without its window is not what is looked at here


if __name__ == "__main__":
    main()
