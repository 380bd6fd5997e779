"""The casing models, one file each: none, rigid, static, craig-bampton."""
