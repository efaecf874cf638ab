"""What others do: the methods of the thesis's Table 1, those of OpenCV, and the exact cuts of its Appendix A, to measure ours against."""
