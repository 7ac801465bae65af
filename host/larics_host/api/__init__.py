"""The Python API: `from larics_host import Camera`. See larics_host.api.camera and larics_host.api.items."""
