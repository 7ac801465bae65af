"""Frames from files, folders, videos and streams; pictures with detections."""
