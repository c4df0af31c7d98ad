"""Landmarks: the detector and its model file, on pictures, scans and rigs."""
