"""Calls of the server in the background, as QGIS' tasks: with progress in its task manager, and to be cancelled there."""
import traceback

from qgis.core import Qgis, QgsApplication, QgsMessageLog, QgsTask

from .skyquilt import SkyquiltError


class Cancelled(Exception):
    """The user cancelled the task."""


class Work(QgsTask):
    """`call(tell)` in a thread of its own, where `tell` takes the client's progress; then, in the main thread, `done(result)` or
    `failed(sentence)`. Neither where it was cancelled: then `cancelled()`."""

    def __init__(self, title, client, call, done, failed, cancelled):
        super().__init__(title, QgsTask.CanCancel)
        self._client, self._call, self._done, self._failed, self._cancelled = client, call, done, failed, cancelled
        self._result, self._error, self.flight_id = None, None, None
        self.last = None  # of the progress; read by the main thread

    def _report(self, progress):
        self.last = progress
        self.flight_id = progress.flight_id or self.flight_id
        self.setProgress(100.0 * progress.fraction)
        if self.isCanceled():
            raise Cancelled

    def run(self):
        """By QGIS, in a thread."""
        try:
            self._result = self._call(self._report)
            return True
        except Cancelled:
            return False
        except (SkyquiltError, OSError) as error:
            self._error = str(error)
            self.flight_id = getattr(error, "flight_id", None) or self.flight_id
        except Exception as error:  # a defect of the plugin must not end QGIS
            QgsMessageLog.logMessage(traceback.format_exc(), "Skyquilt", Qgis.Critical)
            self._error = f"{type(error).__name__}: {error}. The log, page Skyquilt, has more."
        finally:
            self._client.close()  # this thread's connection
        return False

    def finished(self, is_done):
        """By QGIS, in the main thread."""
        if is_done:
            self._done(self._result)
        elif self._error is not None:
            self._failed(self._error)
        else:
            self._cancelled()


class Workers:
    """Starts work and keeps it until it has ended; nothing is called after `end`."""

    def __init__(self):
        self._running = set()
        self._is_over = False

    def start(self, title, client, call, done, failed, *, cancelled=None):
        """The task that was started."""
        def ending(then):
            def end(*said):
                self._running.discard(work)
                if then is not None and not self._is_over:
                    then(*said)
            return end
        work = Work(title, client, call, ending(done), ending(failed), ending(cancelled))
        self._running.add(work)
        QgsApplication.taskManager().addTask(work)
        return work

    def end(self):
        """Cancels what runs."""
        self._is_over = True
        for work in list(self._running):
            work.cancel()
