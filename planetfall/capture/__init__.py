"""Pictures and videos kept in files: photos, captures, recordings, galleries, shots."""
