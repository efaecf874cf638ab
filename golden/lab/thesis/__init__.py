"""Every figure and table of the thesis that pictures can be measured for, and ours beside them."""
