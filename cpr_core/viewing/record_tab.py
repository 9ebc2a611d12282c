# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The tab that records: a GIF of the scene and a YAML of what is on screen, for the browser to keep."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from .background import Background, Task
from .controls import Do
from .recorded import as_gif, as_yaml
from .status_panel import as_plain

if TYPE_CHECKING:
    import viser

__all__ = ["RecordTab"]

#: Pictures a second, their size, how many at most, and how long one may take [s].
_RATE, _HEIGHT, _WIDTH, _MOST, _PATIENCE = 8.0, 480, 640, 240, 10.0


class RecordTab:
    """Whoever presses a button gets the file."""

    def __init__(self, gui: viser.GuiApi, do: Do, name: str, background: Background) -> None:
        self._do, self._name, self._background = do, name, background
        self._recording = False
        save: Any = gui.add_button("save YAML")
        self._record: Any = gui.add_button("record GIF")
        self._text = gui.add_markdown("The scene as this browser shows it, without this panel.")

        async def saved(event: Any) -> None:
            client = event.client
            self._do("save", lambda handled: self._send(client, "yaml", as_yaml(handled).encode()))

        async def pressed(event: Any) -> None:
            if self._recording:
                self._background.stop("record")
            else:
                client = event.client
                self._recording, self._record.label = True, "stop and save"
                self._background.start("record", lambda task: self._film(client, task))

        save.on_click(saved)
        self._record.on_click(pressed)

    def _film(self, client: Any, task: Task) -> None:
        frames: list[Any] = []
        begin, problem = time.monotonic(), ""
        try:
            while not task.stopped() and len(frames) < _MOST:
                frames.append(client.get_render(_HEIGHT, _WIDTH, timeout=_PATIENCE))
                self._text.content = f"{len(frames)} pictures"
                wait = begin + len(frames) / _RATE - time.monotonic()
                if wait > 0.0:
                    time.sleep(wait)
        except Exception as error:  # the browser is gone, or shows nothing
            problem = f"recording ended: {error!r:.200}"
        took = time.monotonic() - begin
        self._recording, self._record.label = False, "record GIF"
        if frames:
            self._send(client, "gif", as_gif(frames, len(frames) / took))
            problem = problem or f"{len(frames)} pictures in {took:.1f} s"
        self._text.content = as_plain(problem)

    def _send(self, client: Any, ending: str, content: bytes) -> None:
        client.send_file_download(f"{self._name}.{ending}", content, save_immediately=True)
