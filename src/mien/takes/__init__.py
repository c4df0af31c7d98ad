"""Marker takes before any face: head motion, gaps, depth reliability, weights and pose of every frame."""
