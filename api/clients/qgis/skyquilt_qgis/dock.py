"""The panel beside the map: the server's flights, what goes on, and the photos of a place."""
from qgis.PyQt.QtCore import QSize, Qt, pyqtSignal
from qgis.PyQt.QtGui import QColor
from qgis.PyQt.QtWidgets import (QAbstractItemView, QDockWidget, QHBoxLayout, QHeaderView, QLabel, QMenu, QProgressBar, QSplitter,
                                 QToolButton, QTreeWidget, QTreeWidgetItem, QVBoxLayout, QWidget)

from qgis.core import QgsApplication

from . import layers
from .photos_panel import PhotosPanel

STATES = {"empty": "no photos yet", "uploaded": "no map yet", "queued": "waits", "processing": "map is made", "failed": "failed"}
KINDS = ((layers.TILES, "Map (tiles)", "Quick, and always the newest map"),
         (layers.GEOTIFF, "Map (GeoTIFF)", "Read where it lies at the server, for analysis"),
         (layers.FOOTPRINTS, "Outlines of the photos", "The ground that each photo shows"),
         (layers.SURFACE, "Heights: surface", "Of ground, roofs and trees, where the map was made with heights"),
         (layers.HILLSHADE, "Heights: hillshade", "Their slopes in the light, to lay below other layers"),
         (layers.GROUND, "Heights: ground", "Below houses and trees, where the map was made with those of the ground"),
         (layers.CONTOURS, "Heights: contours", "Lines of equal height of that ground"))


def described_state(record):
    """A flight's state in few words."""
    if record["state"] == "ready":
        size = record["gsd_m"]
        return f"{100 * size:.1f} cm" if size else "ready"
    job = record["job"]
    if record["state"] == "processing" and job is not None:
        return f"{100 * job['progress']:.0f} %"
    return STATES.get(record["state"], record["state"])


def day_of(record):
    """The day it was flown, else that of the upload."""
    return (record["captured"]["first"] if record["captured"] else record["created_at"])[:10]


class Dock(QDockWidget):
    """Says by its signals what the user wants; shows what it is told."""

    refresh_wanted = pyqtSignal()
    settings_wanted = pyqtSignal()
    upload_wanted = pyqtSignal()
    layer_wanted = pyqtSignal(str)
    place_wanted = pyqtSignal()
    cancel_wanted = pyqtSignal()

    def __init__(self, parent):
        super().__init__("Skyquilt", parent)
        self.setObjectName("SkyquiltDock")
        self.server = QLabel()
        self.server.setTextInteractionFlags(Qt.TextSelectableByMouse)
        self.flights = QTreeWidget()
        self.flights.setHeaderLabels(["Flight", "Flown", "Photos", "Map"])
        self.flights.setRootIsDecorated(False)
        self.flights.setUniformRowHeights(True)
        self.flights.setSelectionMode(QAbstractItemView.SingleSelection)
        self.flights.header().setSectionResizeMode(0, QHeaderView.Stretch)
        self.flights.header().setStretchLastSection(False)
        for column in (1, 2, 3):
            self.flights.header().setSectionResizeMode(column, QHeaderView.ResizeToContents)
        self.flights.itemSelectionChanged.connect(self._chosen)
        self.flights.itemDoubleClicked.connect(lambda *_: self.layer_wanted.emit(layers.TILES) if self._may_add() else None)
        self.add = self._button("mActionAddLayer.svg", "Add", "Add the chosen flight's map to the project")
        self.add.setPopupMode(QToolButton.InstantPopup)
        menu = QMenu(self.add)
        menu.setToolTipsVisible(True)
        for kind, text, about in KINDS:
            action = menu.addAction(text)
            action.setToolTip(about)
            action.triggered.connect(lambda _, kind=kind: self.layer_wanted.emit(kind))
        menu.addSeparator()
        menu.addAction("Only go there").triggered.connect(self.place_wanted)
        self.add.setMenu(menu)
        self.upload = self._button("mActionSharingExport.svg", "Upload", "Send a folder of photos and have a map made")
        self.upload.clicked.connect(self.upload_wanted)
        self.place = self._button("mActionIdentify.svg", "Photos of a place", "Click on the map: which photos see the place")
        self.place.setCheckable(True)
        again = self._button("mActionRefresh.svg", "", "Ask the server again")
        again.clicked.connect(self.refresh_wanted)
        settings = self._button("mActionOptions.svg", "", "Server and token")
        settings.clicked.connect(self.settings_wanted)
        self.said = QLabel()
        self.said.setWordWrap(True)
        self.bar = QProgressBar()
        self.bar.setMaximum(1000)
        self.cancel = self._button("mActionCancelEdits.svg", "", "Stop; what has arrived stays at the server")
        self.cancel.clicked.connect(self.cancel_wanted)
        self.photos = PhotosPanel()
        self.photos.wanted.connect(lambda *_: self.photos.show())
        self._lay_out(again, settings)
        self.show_progress(None)
        self.photos.hide()
        self._chosen()

    def _lay_out(self, again, settings):
        head = QHBoxLayout()
        head.addWidget(self.server, 1)
        head.addWidget(again)
        head.addWidget(settings)
        tools = QHBoxLayout()
        for button in (self.add, self.upload, self.place):
            tools.addWidget(button)
        tools.addStretch(1)
        going = QHBoxLayout()
        going.addWidget(self.bar, 1)
        going.addWidget(self.cancel)
        above = QWidget()
        rows = QVBoxLayout(above)
        rows.setContentsMargins(0, 0, 0, 0)
        rows.addLayout(head)
        rows.addWidget(self.flights, 1)
        rows.addLayout(tools)
        rows.addWidget(self.said)
        rows.addLayout(going)
        parts = QSplitter(Qt.Vertical)
        parts.addWidget(above)
        parts.addWidget(self.photos)
        body = QWidget()
        whole = QVBoxLayout(body)
        whole.addWidget(parts)
        self.setWidget(body)

    @staticmethod
    def _button(icon, text, about):
        button = QToolButton()
        button.setIcon(QgsApplication.getThemeIcon(icon))
        button.setIconSize(QSize(16, 16))
        button.setText(text)
        button.setToolTip(about)
        button.setToolButtonStyle(Qt.ToolButtonTextBesideIcon if text else Qt.ToolButtonIconOnly)
        button.setAutoRaise(True)
        return button

    def show_server(self, url):
        """The address above the list."""
        self.server.setText(url)
        self.server.setToolTip(url)

    def show_flights(self, records):
        """The list anew; what was chosen stays chosen."""
        chosen = self.chosen_id()
        self.flights.clear()
        for record in records:
            photos = record["photos"]["total"] if record["photos"] else record["file_count"]
            item = QTreeWidgetItem([record["name"], day_of(record), str(photos), described_state(record)])
            item.setData(0, Qt.UserRole, record)
            item.setTextAlignment(2, Qt.AlignRight | Qt.AlignVCenter)
            item.setToolTip(0, record["error"]["message"] if record["error"] else record["name"])
            if record["revision"] is None:
                item.setForeground(0, QColor("gray"))
            self.flights.addTopLevelItem(item)
            if record["id"] == chosen:
                self.flights.setCurrentItem(item)
        self.say("" if records else "There are no flights yet. Upload sends a folder of photos.")

    def choose(self, flight_id):
        """Selects a flight of the list."""
        for row in range(self.flights.topLevelItemCount()):
            item = self.flights.topLevelItem(row)
            if item.data(0, Qt.UserRole)["id"] == flight_id:
                self.flights.setCurrentItem(item)

    def chosen(self):
        """The chosen flight's record, or None."""
        items = self.flights.selectedItems()
        return items[0].data(0, Qt.UserRole) if items else None

    def chosen_id(self):
        """Its id, or None."""
        record = self.chosen()
        return record["id"] if record else None

    def records(self):
        """All that are listed, the chosen one first."""
        rows = range(self.flights.topLevelItemCount())
        listed = [self.flights.topLevelItem(row).data(0, Qt.UserRole) for row in rows]
        return sorted(listed, key=lambda record: record["id"] != self.chosen_id())

    def say(self, text):
        """A sentence below the list; none hides it."""
        self.said.setText(text)
        self.said.setVisible(bool(text))

    def show_progress(self, progress):
        """Of an upload; None: there is none."""
        self.bar.setVisible(progress is not None)
        self.cancel.setVisible(progress is not None)
        if progress is not None:
            self.bar.setValue(round(1000 * progress.fraction))
            self.say(progress.message)

    def _may_add(self):
        record = self.chosen()
        return record is not None and record["revision"] is not None

    def _chosen(self):
        self.add.setEnabled(self._may_add())
