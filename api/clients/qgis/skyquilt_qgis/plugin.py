"""What the plugin does: takes the user's wishes from the panel, asks the server in the background, shows what comes."""
import os
import pathlib

from qgis.core import Qgis, QgsCoordinateReferenceSystem, QgsCoordinateTransform, QgsProject, QgsRectangle
from qgis.gui import QgsMapToolEmitPoint
from qgis.PyQt.QtCore import Qt, QTimer
from qgis.PyQt.QtGui import QIcon
from qgis.PyQt.QtWidgets import QAction, QFileDialog, QInputDialog

from . import layers, servers
from .dock import Dock
from .settings_dialog import SettingsDialog
from .skyquilt import NotFound, SkyquiltError
from .work import Workers

MENU = "&Skyquilt"
REFRESH_MS, PROGRESS_MS = 20_000, 300
WGS84 = "EPSG:4326"


class SkyquiltPlugin:
    """Made by QGIS, once."""

    def __init__(self, iface):
        self.iface = iface
        self.workers = Workers()
        self.reading_tokens = {}  # flight id: a token for addresses, of this session or of the project
        self.upload_work = None
        self.is_refreshing = False

    def initGui(self):  # noqa: N802
        """By QGIS: puts the panel and its button where they belong."""
        window, icon = self.iface.mainWindow(), QIcon(os.path.join(os.path.dirname(__file__), "icon.svg"))
        self.dock = Dock(window)
        self.dock.refresh_wanted.connect(self.refresh)
        self.dock.settings_wanted.connect(self.change_settings)
        self.dock.upload_wanted.connect(self.choose_upload)
        self.dock.layer_wanted.connect(self.add_layer)
        self.dock.place_wanted.connect(self.go_to_chosen)
        self.dock.cancel_wanted.connect(self.cancel_upload)
        self.dock.photos.wanted.connect(self.load_photo)
        self.dock.visibilityChanged.connect(lambda is_seen: self.refresh() if is_seen else None)
        self.iface.addDockWidget(Qt.RightDockWidgetArea, self.dock)
        self.action = self.dock.toggleViewAction()
        self.action.setIcon(icon)
        self.action.setToolTip("Skyquilt: flights of a server")
        self.iface.addToolBarIcon(self.action)
        self.upload_action = QAction(icon, "Upload a folder of photos ...", window)
        self.upload_action.triggered.connect(self.choose_upload)
        for action in (self.action, self.upload_action):
            self.iface.addPluginToWebMenu(MENU, action)
        self.place_tool = QgsMapToolEmitPoint(self.iface.mapCanvas())
        self.place_tool.canvasClicked.connect(lambda point, _: self.show_photos_at(point))
        self.dock.place.toggled.connect(self.use_place_tool)
        self.iface.mapCanvas().mapToolSet.connect(self.tool_changed)
        self.refresh_timer, self.progress_timer = QTimer(), QTimer()
        # Nothing is asked, not even for the master password, before the panel is seen.
        self.refresh_timer.timeout.connect(lambda: self.refresh() if self.dock.isVisible() else None)
        self.refresh_timer.start(REFRESH_MS)
        self.progress_timer.timeout.connect(self.show_upload)

    def unload(self):
        """By QGIS: takes everything away again."""
        self.workers.end()
        self.refresh_timer.stop()
        self.progress_timer.stop()
        self.iface.mapCanvas().mapToolSet.disconnect(self.tool_changed)
        self.iface.mapCanvas().unsetMapTool(self.place_tool)
        for action in (self.action, self.upload_action):
            self.iface.removePluginWebMenu(MENU, action)
        self.iface.removeToolBarIcon(self.action)
        self.iface.removeDockWidget(self.dock)
        self.dock.deleteLater()

    def complain(self, text):
        """Where QGIS says what went wrong, and in the panel."""
        self.dock.say(text)
        self.iface.messageBar().pushMessage("Skyquilt", text, Qgis.Warning)

    def connect(self):
        """A client, or None where the address is none, which is said."""
        try:
            return servers.connect()
        except SkyquiltError as error:
            self.complain(str(error))
            return None

    # Flights

    def refresh(self):
        """Asks for the list."""
        client = None if self.is_refreshing else self.connect()
        if client is None:
            return
        self.is_refreshing = True
        self.dock.show_server(client.url)

        def show(records):
            self.is_refreshing = False
            self.dock.show_flights(records)

        def fail(text):
            self.is_refreshing = False
            self.dock.say(text)

        self.workers.start("Flights of Skyquilt", client, lambda tell: [flight.record for flight in client.each_flight()], show, fail,
                           cancelled=lambda: fail(""))

    def change_settings(self):
        """Asks for another server or token."""
        if SettingsDialog(self.iface.mainWindow()).exec_():
            self.reading_tokens.clear()
            self.dock.show_flights([])
            self.refresh()

    # Layers

    def add_layer(self, kind):
        """The chosen flight's map, as `kind`, into the project."""
        record, client = self.dock.chosen(), self.connect()
        if record is None or client is None:
            return
        sources = [layer.source() for layer in QgsProject.instance().mapLayers().values()]
        for flight_id, token in layers.links_in(client.url, sources).items():
            self.reading_tokens.setdefault(flight_id, token)
        self.workers.start(f"Map of {record['name']}", client, lambda tell: layers.described(client, record["id"], self.reading_tokens),
                           lambda map_of: self.show_layer(map_of, kind), self.complain)

    def show_layer(self, map_of, kind):
        """Adds it and goes there."""
        needed = layers.lacking(map_of, kind)
        if needed is not None:
            self.complain(f"The map of {map_of.name} was made without these heights. Make it again with heights: {needed}.")
            return
        layer = layers.layer_of(map_of, kind)
        if not layer.isValid():
            reason = layer.error().summary() or "no reason is known"
            if map_of.token:
                reason = reason.replace(map_of.token, "...")
            self.complain(f"The map of {map_of.name} cannot be opened: {reason}")
            return
        QgsProject.instance().addMapLayer(layer)
        # After QGIS itself, which shows all of a first layer and stays where it is at others.
        QTimer.singleShot(0, lambda: self.go_to(map_of.bounds, layer))
        if map_of.has_new_link:
            self.iface.messageBar().pushMessage(
                "Skyquilt", f"The project now holds a link that reads the map of {map_of.name} and does not end by itself. Share on the "
                "server's page ends it, and these layers with it.", Qgis.Info)

    def go_to(self, bounds, layer=None):
        """Shows west, south, east, north on the canvas; `layer`: what was added of the map."""
        canvas = self.iface.mapCanvas()
        project = canvas.mapSettings().destinationCrs()
        extent = self.extent_of(bounds, project)
        # Files of a map across the antimeridian go on beyond it, where tiles lie at the other end of the world.
        if bounds[2] > 180 and layer is not None and layer.providerType() == "gdal" and layer.crs() == project:
            extent = layer.extent()
        extent.scale(1.05)
        canvas.setExtent(extent)
        canvas.refresh()

    def extent_of(self, bounds, project):
        """In the project's coordinates. A map across the antimeridian is in one piece in few systems; in others, whose ends its
        sides are, this is the wider one."""
        to_project = self.transform(WGS84, project)
        sides = [to_project.transformBoundingBox(QgsRectangle(*side)) for side in layers.sides_of(bounds)]
        whole = QgsRectangle(sides[0])
        for side in sides[1:]:
            whole.combineExtentWith(side)
        is_together = whole.width() < 2 * sum(side.width() for side in sides)
        return whole if is_together else max(sides, key=lambda side: side.width())

    def go_to_chosen(self):
        """Shows where the chosen flight is."""
        record = self.dock.chosen()
        if record is not None and record["bounds"] is not None:
            self.go_to(record["bounds"])

    @staticmethod
    def transform(source, target):
        """From one coordinate system to another."""
        return QgsCoordinateTransform(QgsCoordinateReferenceSystem(source), QgsCoordinateReferenceSystem(target), QgsProject.instance())

    # Uploads

    def choose_upload(self):
        """Asks for a folder and a name."""
        if self.upload_work is not None:
            self.complain("An upload is running; the next can begin when it has ended.")
            return
        folder = QFileDialog.getExistingDirectory(self.iface.mainWindow(), "Folder of photos and logs")
        if not folder:
            return
        name, is_wanted = QInputDialog.getText(self.iface.mainWindow(), "Upload", "Name of the flight", text=pathlib.Path(folder).name)
        if is_wanted:
            self.upload(folder, name.strip() or pathlib.Path(folder).name)

    def upload(self, folder, name, flight_id=None):
        """Sends a folder and waits for the map, in the background."""
        client = self.connect()
        if client is None:
            return

        def call(tell):
            return client.upload(folder, name=name, flight=flight_id, progress=tell).wait(tell).record

        def done(record):
            self.end_upload()
            self.iface.messageBar().pushMessage("Skyquilt", f"The map of {record['name']} is there.", Qgis.Success)
            self.refresh_and_choose(record["id"])

        def failed(text):
            self.end_upload()
            self.complain(text)
            self.refresh()

        def cancelled():
            is_sent = self.upload_work.last is not None and self.upload_work.last.stage not in ("upload", "waiting")
            self.end_upload()
            self.dock.say("The map is no longer waited for; the server goes on with it." if is_sent else
                          "The upload was stopped. What has arrived stays at the server.")

        self.upload_work = self.workers.start(f"Upload of {name}", client, call, done, failed, cancelled=cancelled)
        self.progress_timer.start(PROGRESS_MS)

    def show_upload(self):
        """The progress, in the panel."""
        if self.upload_work is not None and self.upload_work.last is not None:
            self.dock.show_progress(self.upload_work.last)

    def end_upload(self):
        """No upload runs any more."""
        self.upload_work = None
        self.progress_timer.stop()
        self.dock.show_progress(None)
        self.dock.say("")

    def cancel_upload(self):
        """Stops at the next progress."""
        if self.upload_work is not None:
            self.upload_work.cancel()

    def refresh_and_choose(self, flight_id):
        """Asks for the list and chooses one of it."""
        client = self.connect()
        if client is None:
            return

        def show(records):
            self.dock.show_flights(records)
            self.dock.choose(flight_id)

        self.workers.start("Flights of Skyquilt", client, lambda tell: [flight.record for flight in client.each_flight()], show, self.dock.say)

    # Photos of a place

    def use_place_tool(self, is_wanted):
        """Takes the tool or lays it down."""
        canvas = self.iface.mapCanvas()
        if is_wanted:
            canvas.setMapTool(self.place_tool)
        else:
            canvas.unsetMapTool(self.place_tool)

    def tool_changed(self, tool, *_):
        """Another tool was taken: the button follows."""
        self.dock.place.setChecked(tool is self.place_tool)

    def show_photos_at(self, point):
        """`point` in the project's coordinates: the photos of all maps there, those of the chosen flight first."""
        client = self.connect()
        if client is None:
            return
        at = self.transform(self.iface.mapCanvas().mapSettings().destinationCrs(), WGS84).transform(point)
        lon, lat = at.x(), at.y()
        if abs(lon) > 180:  # a canvas in degrees goes on beyond the antimeridian
            lon = (lon + 180) % 360 - 180
        flights = [(record["id"], record["name"]) for record in self.dock.records()
                   if record["bounds"] is not None and layers.holds(record["bounds"], lon, lat)]

        def call(tell):
            found = []
            for flight_id, name in flights:
                try:
                    seen = client.api.photos_at(flight_id, lon, lat)["photos"]
                except NotFound:  # a map of others, which has no photos
                    seen = []
                found += [(flight_id, name, photo) for photo in seen]
            return found

        def show(found):
            self.dock.photos.show()
            self.dock.photos.show_place(lon, lat, found)

        self.workers.start("Photos of a place", client, call, show, self.complain)

    def load_photo(self, flight_id, name):
        """A photo of the list."""
        client = self.connect()
        if client is None:
            return

        def call(tell):
            with client.api.get_file(flight_id, name) as answer:
                return answer.read_all()

        self.workers.start(f"Photo {name}", client, call, lambda content: self.dock.photos.show_bytes(flight_id, name, content),
                           lambda text: self.dock.photos.say_of(flight_id, name, text))
