"""What the page saves: corrections, pairs of places, where markers sit, marks on maps, films."""
