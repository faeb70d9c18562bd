"""JupyterHub for a class: the part of jupyterhub_config.py that this book needs. Add your own login and spawner.

Each user's home holds a copy of the book, because chapters write `omx/generated`: with one shared, writable copy a
student's edit would move everybody's arm. The environment may be shared: start the hub's servers with .venv's Python.
"""

import sys

c = get_config()  # noqa: F821 - JupyterHub gives it

# The hub listens on this machine only; put the web server with your certificate in front of it.
c.JupyterHub.bind_url = "http://127.0.0.1:8000"
c.JupyterHub.hub_ip = "127.0.0.1"

c.Spawner.default_url = "/lab"
# Kept by SystemdSpawner, DockerSpawner and KubeSpawner. The default spawner ignores both: choose another for a class.
c.Spawner.mem_limit = "1G"  # a kernel with NumPy, SymPy and Matplotlib takes about 250 MB
c.Spawner.cpu_limit = 1.0
c.Spawner.start_timeout = 120
c.Spawner.args = [
    # Over TCP, kernels that start in the same second now and then draw the same port. A socket's name may have 107
    # characters: with homes longer than 28 characters, set JUPYTER_RUNTIME_DIR to a short folder of each user's own.
    "--KernelManager.transport=ipc",
    # Idle kernels end after 20 minutes, and the server after 10 more, so that forgotten ones make room.
    "--MappingKernelManager.cull_idle_timeout=1200",
    "--MappingKernelManager.cull_interval=60",
    "--ServerApp.shutdown_no_activity_timeout=600",
    # Nothing is asked of the internet.
    "--LabApp.news_url=None",
    "--LabApp.check_for_updates_class=jupyterlab.handlers.announcements.NeverCheckForUpdate",
    "--LabApp.extension_manager=readonly",
]
c.Spawner.cmd = [sys.executable, "-m", "jupyterhub.singleuser"]
c.Spawner.environment = {"JUPYTERHUB_SINGLEUSER_APP": "jupyter_server.serverapp.ServerApp"}
