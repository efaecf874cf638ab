"""The laboratory: measures the golden model on pictures, searches parameters, compares with other methods.

Commands: ``evaluate``, ``cameras``, ``boards``, ``sparsification``, ``tune``, ``bench``, ``pairing_bench``; and the rooms
``rivals`` and ``thesis``. May import all of ``golden``; nothing else in ``golden`` but its command line may import it.
"""
