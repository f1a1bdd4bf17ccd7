"""The photos that see a place: a list, and the chosen one with a cross at the place."""
from qgis.PyQt.QtCore import QBuffer, QByteArray, QPointF, QSize, Qt, pyqtSignal
from qgis.PyQt.QtGui import QColor, QImage, QImageReader, QPainter, QPen, QPixmap
from qgis.PyQt.QtWidgets import QLabel, QListWidget, QListWidgetItem, QSizePolicy, QSplitter, QVBoxLayout, QWidget

LARGEST_PX = 2048  # of the picture that is kept
CROSS_PX = 14


def picture_of(content):
    """(a photo's picture as it is stored, not turned by its EXIF, and how much smaller it is); None where it is no picture."""
    buffer = QBuffer()
    buffer.setData(QByteArray(content))
    buffer.open(QBuffer.ReadOnly)
    reader = QImageReader(buffer)
    reader.setAutoTransform(False)
    size = reader.size()
    if not size.isValid():
        return None
    if max(size.width(), size.height()) > LARGEST_PX:
        reader.setScaledSize(size.scaled(QSize(LARGEST_PX, LARGEST_PX), Qt.KeepAspectRatio))
    image = reader.read()
    return None if image.isNull() else (image, image.width() / size.width())


class PhotoView(QLabel):
    """A picture that fits the room it has, with a cross."""

    def __init__(self):
        super().__init__()
        self.setAlignment(Qt.AlignCenter)
        self.setWordWrap(True)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Ignored)
        self._image, self._at = QImage(), QPointF()

    def show_photo(self, image, at):
        """`at`: the place in the picture, in its pixels."""
        self._image, self._at = image, at
        self._draw()

    def say(self, text):
        """Words in place of a picture."""
        self._image = QImage()
        self.setPixmap(QPixmap())
        self.setText(text)

    def resizeEvent(self, event):  # noqa: N802
        super().resizeEvent(event)
        self._draw()

    def _draw(self):
        if self._image.isNull():
            return
        pixmap = QPixmap.fromImage(self._image.scaled(self.size(), Qt.KeepAspectRatio, Qt.SmoothTransformation))
        factor = pixmap.width() / self._image.width()
        at = QPointF((self._at.x() + 0.5) * factor, (self._at.y() + 0.5) * factor)
        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.Antialiasing)
        for color, width in ((QColor("white"), 4), (QColor("#c2410c"), 2)):
            painter.setPen(QPen(color, width))
            painter.drawEllipse(at, CROSS_PX / 2, CROSS_PX / 2)
            for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                painter.drawLine(at + QPointF(x, y) * (CROSS_PX / 2), at + QPointF(x, y) * CROSS_PX)
        painter.end()
        self.setPixmap(pixmap)


class PhotosPanel(QWidget):
    """`wanted(flight_id, name)` asks for a photo's bytes, which `show_bytes` takes."""

    wanted = pyqtSignal(str, str)

    def __init__(self):
        super().__init__()
        self.title = QLabel()
        self.title.setWordWrap(True)
        self.list = QListWidget()
        self.list.currentItemChanged.connect(self._chosen)
        self.view = PhotoView()
        parts = QSplitter(Qt.Vertical)
        parts.addWidget(self.list)
        parts.addWidget(self.view)
        parts.setStretchFactor(1, 1)
        parts.setSizes([120, 280])
        rows = QVBoxLayout(self)
        rows.setContentsMargins(0, 0, 0, 0)
        rows.addWidget(self.title)
        rows.addWidget(parts, 1)

    def show_place(self, lon, lat, found):
        """`found`: (flight id, flight's name, photo as the server told) in order."""
        self.list.clear()
        self.view.say("")
        count = f"{len(found)} photos see" if len(found) != 1 else "One photo sees"
        self.title.setText(f"{count if found else 'No photo of a listed map sees'} {lat:.6f}, {lon:.6f}")
        several = len({flight_id for flight_id, _, _ in found}) > 1
        for flight_id, flight_name, photo in found:
            text = f"{photo['name']}   {photo['off_nadir_deg']:.0f}° off the vertical"
            item = QListWidgetItem(f"{flight_name}: {text}" if several else text)
            item.setData(Qt.UserRole, (flight_id, photo))
            item.setToolTip(f"Pixel {photo['x']:.0f}, {photo['y']:.0f}; {photo['placement'].replace('_', ' ')}")
            self.list.addItem(item)
        if found:
            self.list.setCurrentRow(0)

    def _chosen(self, item):
        if item is not None:
            flight_id, photo = item.data(Qt.UserRole)
            self.view.say("Loading the photo ...")
            self.wanted.emit(flight_id, photo["name"])

    def show_bytes(self, flight_id, name, content):
        """A photo that came; passed over where another was chosen meanwhile."""
        photo = self._awaited(flight_id, name)
        if photo is None:
            return
        picture = picture_of(content)
        if picture is None:
            self.view.say(f"{name} cannot be shown here.")
            return
        image, factor = picture
        self.view.show_photo(image, QPointF(photo["x"] * factor, photo["y"] * factor))

    def say_of(self, flight_id, name, text):
        """Why a photo did not come."""
        if self._awaited(flight_id, name) is not None:
            self.view.say(text)

    def _awaited(self, flight_id, name):
        item = self.list.currentItem()
        chosen, photo = item.data(Qt.UserRole) if item is not None else (None, None)
        return photo if chosen == flight_id and photo["name"] == name else None
