"""The window in which the server's address and the token are typed."""
from qgis.PyQt.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QFormLayout, QLabel, QLineEdit

from . import servers
from .skyquilt import SkyquiltError


class SettingsDialog(QDialog):
    """Address, token, and whether the token is kept."""

    def __init__(self, parent):
        super().__init__(parent)
        self.setWindowTitle("Skyquilt server")
        self.url = QLineEdit(servers.url())
        self.token = QLineEdit(servers.token() or "")
        self.token.setEchoMode(QLineEdit.Password)
        self.token.setPlaceholderText("only where the server asks for one")
        self.keeps = QCheckBox("Keep the token in QGIS' password store")
        self.keeps.setChecked(servers.is_token_kept())
        self.said = QLabel()
        self.said.setWordWrap(True)
        self.said.hide()
        buttons = QDialogButtonBox(QDialogButtonBox.Ok | QDialogButtonBox.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form = QFormLayout(self)
        form.addRow("Address", self.url)
        form.addRow("Token", self.token)
        form.addRow("", self.keeps)
        form.addRow(self.said)
        form.addRow(buttons)
        self.setMinimumWidth(420)

    def accept(self):
        """Stays open where the address is none, or the token cannot be kept."""
        try:
            is_done = servers.keep(self.url.text(), self.token.text().strip(), self.keeps.isChecked())
        except SkyquiltError as error:
            self.say(str(error))
            return
        if is_done:
            super().accept()
            return
        self.keeps.setChecked(False)
        self.say("QGIS' password store was not opened. The token is used until QGIS ends; OK goes on with that.")

    def say(self, text):
        """A sentence above the buttons."""
        self.said.setText(text)
        self.said.show()
