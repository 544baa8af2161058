"""View: pictures, progress and the browser page."""
